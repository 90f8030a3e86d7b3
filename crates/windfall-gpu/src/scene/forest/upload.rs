//! What is in the GPU's memory of a forest, and how it follows the forest's changes.

use super::{Forest, ForestError, GONE, Moment, Planted, Tree};
use crate::base::shared::{Model, TreeRecord};
use crate::scene::events::{Scripted, scripted_key};
use crate::scene::falls::{LooseState, scripted_buffer, storage};
use crate::scene::model::TreeModel;
use crate::scene::streams::{Room, SCRIPTED_ROOM, Streams};
use crate::scene::trees::{TreeTables, no_tree};
use glam::{Vec3, Vec4};

/// What is in the GPU's memory of the forest; made anew where trees outgrow it.
pub(crate) struct ForestBuffers {
    pub tables: TreeTables,
    pub models: Vec<(TreeModel, u32)>,
    pub tree_buffer: wgpu::Buffer,
    pub model_buffer: wgpu::Buffer,
    pub part_buffer: wgpu::Buffer,
    pub loose: LooseState,
    pub scripted: wgpu::Buffer,
    /// Streams of thrown leaves that have changed.
    pub(super) changed_streams: Vec<u32>,
}

impl Forest {
    /// Begins a moment: brings the GPU's memory up to date with what has changed.
    pub(crate) fn begin(&mut self, queue: &wgpu::Queue, moment: Moment) -> Result<(), ForestError> {
        self.moment = moment;
        self.latest = self.latest.max(moment.time);
        self.sync(queue)
    }

    fn sync(&mut self, queue: &wgpu::Queue) -> Result<(), ForestError> {
        let homeless = std::mem::take(&mut self.homeless);
        for &index in &homeless {
            let Tree { model, slot: None, .. } = self.trees[index] else { continue };
            if model == GONE {
                continue;
            }
            match self.planted[model].free.pop() {
                Some(place) if !self.rebuild => {
                    self.trees[index].slot = Some(place);
                    self.place_again(index);
                }
                _ => self.rebuild = true,
            }
        }
        let thrown = std::mem::take(&mut self.thrown_changed);
        if !self.rebuild {
            for &index in &thrown {
                if self.trees[index].model != GONE && !self.lay_out_thrown(index) {
                    self.rebuild = true;
                    break;
                }
            }
        }
        if self.rebuild {
            self.build(queue)?;
        }
        let Some(buffers) = &mut self.buffers else { return Ok(()) };
        if self.scripted_changed {
            let table = self.scripted.table();
            let bytes: &[u8] = bytemuck::cast_slice(&table);
            if bytes.len() as u64 <= buffers.scripted.size() {
                queue.write_buffer(&buffers.scripted, 0, bytes);
            } else {
                buffers.scripted = scripted_buffer(&self.device, &self.scripted);
                self.structure += 1;
            }
            self.scripted_changed = false;
        }
        self.changed.sort_unstable();
        self.changed.dedup();
        for (model, place) in self.changed.drain(..) {
            buffers.write_place(queue, model, place);
        }
        for stream in std::mem::take(&mut buffers.changed_streams) {
            let loose = &buffers.loose;
            loose.write_stream(queue, stream);
            loose.write_list(queue, loose.streams.words_of(stream));
            loose.forget(queue, stream);
        }
        Ok(())
    }

    /// Makes everything anew, with room for more trees than there are if it had to be made before.
    fn build(&mut self, queue: &wgpu::Queue) -> Result<(), ForestError> {
        let again = self.buffers.is_some();
        let mut rooms = Vec::new();
        let mut leaves = 0;
        for (m, planted) in self.planted.iter().enumerate() {
            let reserve = if again { planted.trees / 4 + 4 } else { 0 };
            let of_model = self.trees.iter().filter(|tree| tree.model == m);
            let needed: u32 = of_model
                .filter(|tree| !tree.thrown.is_empty())
                .map(|tree| 1 + tree.thrown.len() as u32 / SCRIPTED_ROOM)
                .sum();
            let known = self.scripted_room.get(m).copied().unwrap_or(0);
            let scripted = if needed > known { needed.next_power_of_two().max(4) } else { known };
            leaves += u64::from(planted.trees) * u64::from(planted.model.leaf_count);
            rooms.push(Room {
                places: planted.trees + reserve,
                scripted,
                path_group: planted.path_group,
            });
        }
        let trees: u64 = rooms.iter().map(|r| u64::from(r.places).next_multiple_of(64)).sum();
        let limit = self.device.limits().max_storage_buffer_binding_size;
        let most = limit / (crate::base::constants::LISTS as u64 * 64);
        if trees > most {
            return Err(ForestError::TooManyTrees { trees, most });
        }
        let with_rooms: Vec<(TreeModel, Room)> =
            self.planted.iter().map(|p| p.model.clone()).zip(rooms.iter().copied()).collect();
        // Every stream keeps the same share of its leaves.
        let share = (f64::from(self.falls.capacity) / leaves.max(1) as f64).min(1.0);
        let streams = Streams::new(&with_rooms, share);
        let models: Vec<(TreeModel, u32)> =
            with_rooms.iter().map(|(model, room)| (model.clone(), room.places)).collect();
        let tables = TreeTables::new(&models);
        let uniforms: Vec<Model> = models
            .iter()
            .zip(&tables.crowns)
            .map(|((model, _), crown)| Model { crown: *crown, ..model.uniform })
            .collect();
        let device = &self.device;
        let loose = LooseState::new(
            (device, queue),
            &self.layouts,
            &models,
            &uniforms,
            streams,
            (&self.falls, &self.local_wind),
            &self.terrain,
        )?;
        let parts: Vec<[u32; 4]> = tables
            .parts
            .iter()
            .map(|p| {
                let buckets = p.buckets.0 | p.buckets.1 << 8 | p.kind << 16;
                [buckets, 0, p.indices.1, p.indices.0]
            })
            .collect();
        let none = wgpu::BufferUsages::empty();
        self.buffers = Some(ForestBuffers {
            tree_buffer: storage(device, "trees", bytemuck::cast_slice(&tables.records), none),
            model_buffer: storage(device, "models", bytemuck::cast_slice(&uniforms), none),
            part_buffer: storage(device, "parts", bytemuck::cast_slice(&parts), none),
            scripted: scripted_buffer(device, &self.scripted),
            changed_streams: Vec::new(),
            loose,
            tables,
            models,
        });
        self.scripted_room = rooms.iter().map(|room| room.scripted).collect();
        self.litter = litter(&self.planted);
        for (planted, room) in self.planted.iter_mut().zip(&rooms) {
            planted.free = (0..room.places).rev().collect();
        }
        self.homeless.clear();
        self.changed.clear();
        self.scripted = Scripted::default();
        self.rebuild = false;
        self.structure += 1;
        self.generation += 1;
        self.latest = self.moment.time;
        for index in 0..self.trees.len() {
            let model = self.trees[index].model;
            if model == GONE {
                continue;
            }
            self.trees[index].slot = self.planted[model].free.pop();
            self.trees[index].laid_out = 0;
            self.place_again(index);
            // There is room for all that were thrown.
            self.rebuild |= !self.lay_out_thrown(index);
        }
        self.scripted_changed = true;
        // One upload of all.
        if let Some(buffers) = &mut self.buffers {
            buffers.changed_streams.clear();
            let records = bytemuck::cast_slice(&buffers.tables.records);
            queue.write_buffer(&buffers.tree_buffer, 0, records);
            let streams = &buffers.loose.streams;
            let bytes = bytemuck::cast_slice(&streams.all);
            queue.write_buffer(&buffers.loose.stream_buffer, 0, bytes);
            buffers.loose.write_list(queue, 0..streams.shed_lists.len() as u32);
        }
        self.changed.clear();
        Ok(())
    }

    /// Puts a tree where it stands now.
    pub(super) fn place_again(&mut self, index: usize) {
        let Tree { model, slot, .. } = self.trees[index];
        let record = self.record(index);
        if let (Some(buffers), Some(place)) = (&mut self.buffers, slot) {
            buffers.set_place(model, place, Some(&record));
            self.changed.push((model, place));
        }
        if !self.trees[index].thrown.is_empty() {
            self.trees[index].laid_out = 0;
            self.thrown_changed.push(index);
        }
    }

    /// Takes away what is known of a tree's thrown leaves where it stands.
    pub(super) fn clear_thrown(&mut self, index: usize) {
        self.trees[index].laid_out = 0;
        if self.trees[index].thrown.is_empty() || self.trees[index].slot.is_none() {
            return;
        }
        let record = self.record(index);
        self.scripted.remove_tree(scripted_key(record.seed, record.position));
        self.scripted_changed = true;
        let model = self.trees[index].model;
        if let Some(buffers) = &mut self.buffers {
            let cleared = buffers.loose.streams.clear_thrown(model, &record);
            buffers.changed_streams.extend(cleared);
        }
    }

    /// Puts thrown leaves of a tree that have no place yet in streams of their own; whether there was room.
    fn lay_out_thrown(&mut self, index: usize) -> bool {
        let Tree { model, slot: Some(place), laid_out, .. } = self.trees[index] else {
            return true;
        };
        if self.trees[index].thrown.len() == laid_out {
            return true;
        }
        if laid_out == 0 {
            self.clear_thrown(index);
        }
        let record = self.record(index);
        let leaves = self.planted[model].model.leaf_count;
        let [latest, _] = self.clock(self.latest);
        let records = &self.planted[model].model.loose.records;
        let in_season = |leaf: u32| self.detach_time(&record, leaves, records[leaf as usize].rank);
        // Leaves that the season takes before are not thrown.
        let new: Vec<(u32, f32)> = self.trees[index].thrown[laid_out..]
            .iter()
            .copied()
            .filter(|&(leaf, time)| time < in_season(leaf))
            .collect();
        // Streams of the season have to leave out what they may hold already.
        let held = new.iter().any(|&(leaf, _)| in_season(leaf) <= latest);
        let key = scripted_key(record.seed, record.position);
        let shapes = &self.planted[model].model.loose.shape_of;
        let Some(buffers) = &mut self.buffers else { return true };
        for (leaf, time) in new {
            self.scripted.insert(key, leaf, time);
            let shape = shapes[leaf as usize] as usize;
            match buffers.loose.streams.throw((model, shape), &record, leaf, time) {
                Some(stream) => buffers.changed_streams.push(stream),
                None => return false,
            }
        }
        buffers.changed_streams.sort_unstable();
        buffers.changed_streams.dedup();
        self.scripted_changed = true;
        // From the first on its streams know that there are thrown ones.
        if held || laid_out == 0 {
            buffers.set_place(model, place, Some(&record));
            self.changed.push((model, place));
        }
        self.trees[index].laid_out = self.trees[index].thrown.len();
        true
    }
}

impl ForestBuffers {
    pub(super) fn set_place(&mut self, model: usize, place: u32, tree: Option<&TreeRecord>) {
        let at = self.tables.crowns[model].tree_first + place;
        self.tables.records[at as usize] = tree.copied().unwrap_or_else(no_tree);
        self.loose.streams.set_place(model, place, tree);
    }

    /// Writes the tree at a place, and its streams.
    fn write_place(&self, queue: &wgpu::Queue, model: usize, place: u32) {
        let at = self.tables.crowns[model].tree_first + place;
        let record = &self.tables.records[at as usize];
        let size = size_of::<TreeRecord>() as u64;
        queue.write_buffer(&self.tree_buffer, u64::from(at) * size, bytemuck::bytes_of(record));
        for stream in self.loose.streams.of_place(model, place) {
            self.loose.write_stream(queue, stream);
            self.loose.forget(queue, stream);
        }
    }
}

/// Late autumn's colours of all models; of those without a palette, brown.
fn litter(planted: &[Planted]) -> Vec3 {
    let late = |palette: &[Vec4; 8]| (palette[4] + palette[5] + palette[6]).truncate() / 3.0;
    let with_palette = planted.iter().filter(|p| p.model.uniform.palette_count > 0);
    let (sum, count) = with_palette
        .fold((Vec3::ZERO, 0.0), |(sum, n), p| (sum + late(&p.model.uniform.palette), n + 1.0));
    let brown = Vec3::new(0.33, 0.18, 0.05);
    (sum + brown) / (count + 1.0)
}
