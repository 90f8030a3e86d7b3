//! Files of a scene: on disk, or dropped into the window or the page.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::SystemTime;

/// Where files are found.
#[derive(Debug, Clone, Default)]
pub struct Files {
    /// Folder that names in the scene are relative to; empty in browsers.
    pub folder: std::path::PathBuf,
    /// Files without a path, by name.
    pub dropped: BTreeMap<String, Arc<[u8]>>,
    /// The page's function that promises a baked tree's bytes by its name, or nothing.
    #[cfg(target_arch = "wasm32")]
    pub page: Option<js_sys::Function>,
}

/// What a file is, by its name.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// A scene.
    Scene,
    /// A tree, or a fall path: both come as glTF.
    Gltf,
    /// A fall path.
    Path,
    /// A picture of the sky.
    Sky,
}

/// What a file of this name is.
///
/// # Errors
///
/// A sentence for people, where it is nothing that the viewer reads.
pub fn kind(name: &str) -> Result<Kind, String> {
    let ending = name.rsplit_once('.').map_or("", |(_, ending)| ending).to_lowercase();
    match ending.as_str() {
        "ron" => Ok(Kind::Scene),
        "glb" | "gltf" => Ok(Kind::Gltf),
        "csv" | "json" | "path" | "txt" => Ok(Kind::Path),
        "hdr" | "exr" => Ok(Kind::Sky),
        _ => Err(format!(
            "{name}: is no scene (.ron), tree (.glb, .gltf), fall path (.glb, .csv, .json, .path) or \
             picture of the sky (.hdr, .exr)"
        )),
    }
}

impl Files {
    /// The bytes of a file.
    ///
    /// # Errors
    ///
    /// A sentence for people that names the file.
    pub fn read(&self, name: &str) -> Result<Arc<[u8]>, String> {
        if let Some(bytes) = self.dropped.get(name) {
            return Ok(Arc::clone(bytes));
        }
        if cfg!(target_arch = "wasm32") {
            return Err(format!("{name}: is not here; drop it onto the page"));
        }
        let path = self.folder.join(name);
        let bytes = std::fs::read(&path).map_err(|e| format!("{}: {e}", path.display()))?;
        Ok(bytes.into())
    }

    /// A baked species, if the page has it.
    #[cfg(target_arch = "wasm32")]
    pub async fn baked(&self, name: &str) -> Option<Vec<u8>> {
        use wasm_bindgen::JsCast;
        let promise = self.page.as_ref()?.call1(&wasm_bindgen::JsValue::UNDEFINED, &name.into());
        let promise: js_sys::Promise = promise.ok()?.dyn_into().ok()?;
        let bytes = wasm_bindgen_futures::JsFuture::from(promise).await.ok()?;
        Some(bytes.dyn_into::<js_sys::Uint8Array>().ok()?.to_vec())
    }

    /// What tells a dropped file from an older one of the same name.
    pub fn version(&self, name: &str) -> Option<*const u8> {
        self.dropped.get(name).map(|bytes| bytes.as_ptr())
    }

    /// When a file was last written to.
    pub fn modified(&self, name: &str) -> Option<SystemTime> {
        if cfg!(target_arch = "wasm32") || self.dropped.contains_key(name) {
            return None;
        }
        std::fs::metadata(self.folder.join(name)).ok()?.modified().ok()
    }

    /// What a file names beside itself, as `windfall_tree::import` asks for it.
    ///
    /// # Errors
    ///
    /// A sentence for people.
    pub fn beside(&self, name: &str, uri: &str) -> Result<Vec<u8>, String> {
        let folder = std::path::Path::new(name).parent();
        let beside = folder.map_or_else(|| uri.into(), |folder| folder.join(uri));
        self.read(&beside.to_string_lossy()).map(|bytes| bytes.to_vec())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_say_what_files_are() {
        assert_eq!(kind("a/My Oak.GLB"), Ok(Kind::Gltf));
        assert_eq!(kind("sky.exr"), Ok(Kind::Sky));
        assert_eq!(kind("s.ron"), Ok(Kind::Scene));
        assert_eq!(kind("fall.csv"), Ok(Kind::Path));
        assert!(kind("notes.doc").unwrap_err().starts_with("notes.doc: is no scene"));
    }

    #[test]
    fn dropped_files_come_before_the_disk() {
        let mut files = Files::default();
        assert!(files.read("no-such-file.glb").unwrap_err().starts_with("no-such-file.glb: "));
        files.dropped.insert("no-such-file.glb".into(), Arc::from(&b"glTF"[..]));
        assert_eq!(&*files.read("no-such-file.glb").unwrap(), b"glTF");
    }
}
