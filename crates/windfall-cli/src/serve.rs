//! `windfall serve`: the viewer's page, for browsers on this machine alone.

use anyhow::{Context, bail};
use std::io::{BufRead, BufReader, Read, Write};
use std::net::{Ipv4Addr, TcpListener, TcpStream};
use std::path::{Component, Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

/// Longest line of a request, bytes.
const LONGEST: u64 = 8192;

/// Arguments of `windfall serve`.
#[derive(clap::Args)]
pub struct Args {
    /// Folder with the page, as scripts/web makes it
    #[arg(value_name = "FOLDER", default_value = "dist")]
    folder: PathBuf,
    /// Port on the loopback address; 0 takes a free one
    #[arg(long, value_name = "N", default_value_t = 8080)]
    port: u16,
}

/// Runs `windfall serve`: until it is stopped.
pub fn run(args: &Args) -> anyhow::Result<()> {
    if !args.folder.join("index.html").is_file() {
        bail!("{}: has no index.html; scripts/web makes the page", args.folder.display());
    }
    let folder = Arc::new(args.folder.clone());
    let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, args.port))
        .with_context(|| format!("--port {}", args.port))?;
    eprintln!("http://{}/", listener.local_addr()?);
    for stream in listener.incoming() {
        let Ok(stream) = stream else { continue };
        let folder = Arc::clone(&folder);
        // A browser that goes away in the middle is no matter of the server's.
        std::thread::spawn(move || drop(answer(stream, &folder)));
    }
    Ok(())
}

/// Answers one request.
fn answer(stream: TcpStream, folder: &Path) -> std::io::Result<()> {
    stream.set_read_timeout(Some(Duration::from_secs(10)))?;
    let mut reader = BufReader::new(stream.try_clone()?.take(16 * LONGEST));
    let mut request = String::new();
    reader.by_ref().take(LONGEST).read_line(&mut request)?;
    let mut line = String::new();
    while reader.by_ref().take(LONGEST).read_line(&mut line)? > 2 {
        line.clear();
    }
    let mut words = request.split_whitespace();
    let (method, target) = (words.next().unwrap_or(""), words.next().unwrap_or(""));
    let (status, kind, body) = match (method, file(folder, target)) {
        ("GET" | "HEAD", Some(path)) => match std::fs::read(&path) {
            Ok(body) => ("200 OK", kind(&path), body),
            Err(_) => ("404 Not Found", "text/plain", b"There is no such file.\n".to_vec()),
        },
        ("GET" | "HEAD", None) => {
            ("404 Not Found", "text/plain", b"There is no such file.\n".to_vec())
        }
        _ => ("405 Method Not Allowed", "text/plain", b"GET and HEAD alone.\n".to_vec()),
    };
    let mut stream = stream;
    write!(
        stream,
        "HTTP/1.1 {status}\r\nContent-Type: {kind}\r\nContent-Length: {}\r\nCache-Control: no-cache\r\n\
         X-Content-Type-Options: nosniff\r\nConnection: close\r\n\r\n",
        body.len()
    )?;
    if method != "HEAD" {
        stream.write_all(&body)?;
    }
    stream.flush()
}

/// The file that a request means; none outside of the folder.
fn file(folder: &Path, target: &str) -> Option<PathBuf> {
    let path = target.split(['?', '#']).next()?.strip_prefix('/')?;
    let path = Path::new(if path.is_empty() { "index.html" } else { path });
    let inside = path.components().all(|part| matches!(part, Component::Normal(_)));
    (inside && !path.to_string_lossy().contains(['%', '\\', ':'])).then(|| folder.join(path))
}

fn kind(path: &Path) -> &'static str {
    match path.extension().and_then(|ending| ending.to_str()) {
        Some("html") => "text/html; charset=utf-8",
        Some("js") => "text/javascript; charset=utf-8",
        Some("ts") => "text/plain; charset=utf-8",
        Some("json") => "application/json",
        Some("wasm") => "application/wasm",
        Some("webp") => "image/webp",
        Some("png") => "image/png",
        Some("mp4") => "video/mp4",
        _ => "application/octet-stream",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_of_the_folder_alone_are_served() {
        let folder = Path::new("dist");
        assert_eq!(file(folder, "/"), Some("dist/index.html".into()));
        assert_eq!(file(folder, "/a.wasm?x=1"), Some("dist/a.wasm".into()));
        for outside in
            ["/../Cargo.toml", "/a/../../b", "//etc/passwd", "/%2e%2e/b", "x", "", "/C:/x"]
        {
            assert_eq!(file(folder, outside), None, "{outside}");
        }
    }

    #[test]
    fn a_browser_is_given_the_page() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("index.html"), "<p>forest").unwrap();
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).unwrap();
        let address = listener.local_addr().unwrap();
        let ask = |request: &str| {
            let mut stream = TcpStream::connect(address).unwrap();
            stream.write_all(request.as_bytes()).unwrap();
            answer(listener.accept().unwrap().0, folder.path()).unwrap();
            let mut text = String::new();
            stream.read_to_string(&mut text).unwrap();
            text
        };
        let page = ask("GET / HTTP/1.1\r\nHost: x\r\n\r\n");
        assert!(page.starts_with("HTTP/1.1 200 OK\r\nContent-Type: text/html"), "{page}");
        assert!(page.ends_with("\r\n\r\n<p>forest"), "{page}");
        assert!(ask("GET /no HTTP/1.1\r\n\r\n").starts_with("HTTP/1.1 404"));
        assert!(ask("POST / HTTP/1.1\r\n\r\n").starts_with("HTTP/1.1 405"));
        assert!(!ask("HEAD / HTTP/1.1\r\n\r\n").contains("forest"));
    }
}
