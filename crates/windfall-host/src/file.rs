//! Files that appear whole or not at all.

use anyhow::Context;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use tempfile::NamedTempFile;

/// A temporary file that [`Self::commit`] renames to its path. Dropping it removes it.
#[derive(Debug)]
pub struct AtomicFile {
    temporary: NamedTempFile,
    path: PathBuf,
}

impl AtomicFile {
    /// Creates an empty temporary file in the folder of `path`, and the folder if it is missing.
    ///
    /// # Errors
    ///
    /// The folder cannot be created or written to.
    pub fn create(path: &Path) -> anyhow::Result<Self> {
        let folder = match path.parent() {
            Some(folder) if !folder.as_os_str().is_empty() => folder,
            _ => Path::new("."),
        };
        std::fs::create_dir_all(folder)
            .with_context(|| format!("cannot make the folder {}", folder.display()))?;
        let suffix =
            path.extension().map_or(String::new(), |e| format!(".{}", e.to_string_lossy()));
        let temporary = tempfile::Builder::new()
            .prefix(".windfall-")
            .suffix(&suffix)
            .tempfile_in(folder)
            .with_context(|| format!("cannot write into {}", folder.display()))?;
        Ok(Self { temporary, path: path.to_owned() })
    }

    /// Where the file will be.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Where the file is now, for another program to write. It has the same extension.
    pub fn temporary_path(&self) -> &Path {
        self.temporary.path()
    }

    /// Another handle of the temporary file, for writers that own theirs.
    ///
    /// # Errors
    ///
    /// The temporary file cannot be opened again.
    pub fn reopen(&self) -> std::io::Result<File> {
        self.temporary.reopen()
    }

    /// Renames the temporary file to its path. Everything must have been written and flushed.
    ///
    /// # Errors
    ///
    /// The path cannot be written, for example because it is a folder.
    pub fn commit(self) -> anyhow::Result<()> {
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            // Temporary files are private; output files are readable by everyone.
            let mode = std::fs::Permissions::from_mode(0o644);
            std::fs::set_permissions(self.temporary.path(), mode)
                .context("cannot set permissions")?;
        }
        let path = self.path;
        self.temporary
            .persist(&path)
            .with_context(|| format!("cannot write {}", path.display()))?;
        Ok(())
    }
}

/// Writes a file through a temporary one in the same folder.
///
/// # Errors
///
/// `write` fails, or the file cannot be written; then there is no file at `path`, or the old one.
pub fn write_atomic(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<&mut File>) -> anyhow::Result<()>,
) -> anyhow::Result<()> {
    let mut file = AtomicFile::create(path)?;
    let mut writer = BufWriter::new(file.temporary.as_file_mut());
    write(&mut writer).with_context(|| format!("cannot write {}", path.display()))?;
    writer.flush().with_context(|| format!("cannot write {}", path.display()))?;
    drop(writer);
    file.commit()
}

#[cfg(test)]
mod tests {
    use super::*;
    use anyhow::bail;

    #[test]
    fn a_file_that_fails_half_way_is_not_there() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("new").join("a.png");
        let failed = write_atomic(&path, |file| {
            file.write_all(b"half")?;
            bail!("no more")
        });
        assert!(format!("{:#}", failed.unwrap_err()).contains("a.png: no more"));
        assert_eq!(std::fs::read_dir(path.parent().unwrap()).unwrap().count(), 0);
        write_atomic(&path, |file| Ok(file.write_all(b"whole")?)).unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), b"whole");
    }
}
