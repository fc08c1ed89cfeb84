//! What the examples share that a command line calls for.

use std::error::Error;
use std::ffi::OsString;
use std::io;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Runs an example; an error goes to the standard error as the sentence that it is.
pub(crate) fn run(example: impl FnOnce() -> Result<(), Box<dyn Error>>) -> ExitCode {
    match example() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            if error.is::<lexopt::Error>() {
                eprintln!("`--help` shows the options");
            }
            ExitCode::FAILURE
        }
    }
}

/// Shows the help, and that is all.
pub(crate) fn show(help: &str) -> ! {
    print!("{help}");
    std::process::exit(0)
}

/// A whole number in a range.
pub(crate) fn number(text: &str, range: RangeInclusive<u32>) -> Result<u32, String> {
    let number = text.parse().ok().filter(|number| range.contains(number));
    number.ok_or_else(|| format!("give a whole number from {} to {}", range.start(), range.end()))
}

/// The name of a PNG file.
pub(crate) fn png(name: OsString) -> Result<PathBuf, String> {
    let path = PathBuf::from(name);
    if path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("png")) {
        Ok(path)
    } else {
        Err(format!("cannot write {}: choose a name that ends in .png", path.display()))
    }
}

/// Makes the folder that a file goes to, if it is not there.
pub(crate) fn make_folder_of(file: &Path) -> io::Result<()> {
    let Some(folder) = file.parent() else { return Ok(()) };
    std::fs::create_dir_all(folder).map_err(|error| {
        let sentence = format!("cannot make the folder {}: {error}", folder.display());
        io::Error::new(error.kind(), sentence)
    })
}
