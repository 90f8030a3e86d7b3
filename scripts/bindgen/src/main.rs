//! `bindgen PROGRAM.wasm FOLDER`

use wasm_bindgen_cli_support::Bindgen;

fn main() {
    let mut words = std::env::args().skip(1);
    let (Some(program), Some(folder), None) = (words.next(), words.next(), words.next()) else {
        eprintln!("bindgen PROGRAM.wasm FOLDER");
        std::process::exit(2);
    };
    let made = || {
        Bindgen::new()
            .input_path(program)
            .web(true)?
            .typescript(false)
            .remove_name_section(true)
            .remove_producers_section(true)
            .generate(folder)
    };
    if let Err(error) = made() {
        eprintln!("{error:#}");
        std::process::exit(1);
    }
}
