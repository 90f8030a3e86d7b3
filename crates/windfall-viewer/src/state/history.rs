//! Undo and redo.

use crate::state::settings::Settings;

/// Most steps that are kept.
const STEPS: usize = 200;

/// States before and after the present one.
#[derive(Debug, Default)]
pub struct History {
    past: Vec<Settings>,
    future: Vec<Settings>,
    /// Whether the last change goes on, as while a slider is dragged.
    open: bool,
}

impl History {
    /// Notes that `before` was changed. Changes up to the next [`History::settle`] are one step.
    pub fn changed(&mut self, before: &Settings) {
        self.future.clear();
        if self.open {
            return;
        }
        self.open = true;
        self.past.push(before.clone());
        if self.past.len() > STEPS {
            self.past.remove(0);
        }
    }

    /// The change is over: the next one is another step.
    pub fn settle(&mut self) {
        self.open = false;
    }

    /// Whether there is a step to take back.
    pub fn can_undo(&self) -> bool {
        !self.past.is_empty()
    }

    /// Whether there is a step to take again.
    pub fn can_redo(&self) -> bool {
        !self.future.is_empty()
    }

    /// Takes the last step back.
    pub fn undo(&mut self, settings: &mut Settings) {
        self.open = false;
        if let Some(before) = self.past.pop() {
            self.future.push(std::mem::replace(settings, before));
        }
    }

    /// Takes it again.
    pub fn redo(&mut self, settings: &mut Settings) {
        self.open = false;
        if let Some(after) = self.future.pop() {
            self.past.push(std::mem::replace(settings, after));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_drag_is_one_step_and_comes_back() {
        let mut settings = Settings::named("lone-oak").unwrap();
        let mut history = History::default();
        let first = settings.scene.season;
        let set = |history: &mut History, settings: &mut Settings, season| {
            history.changed(settings);
            settings.scene.season = season;
        };
        for season in [0.1, 0.2, 0.3] {
            set(&mut history, &mut settings, season);
        }
        history.settle();
        set(&mut history, &mut settings, 0.9);
        history.settle();
        history.undo(&mut settings);
        assert_eq!(settings.scene.season, 0.3);
        history.undo(&mut settings);
        assert_eq!((settings.scene.season, history.can_undo()), (first, false));
        history.redo(&mut settings);
        history.redo(&mut settings);
        assert_eq!((settings.scene.season, history.can_redo()), (0.9, false));
        history.undo(&mut settings);
        set(&mut history, &mut settings, 0.5);
        assert!(!history.can_redo());
    }
}
