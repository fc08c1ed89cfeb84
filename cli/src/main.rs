//! Pictures of 3D models: `polyscan model.glb -o picture.png`.
//!
//! What flows in are the options (`options`), which are checked before anything is read; then the models, each
//! of which is loaded and drawn (`job`): seen by a camera (`view`), drawn (`draw`, by the shaders of `looks` and the lines of `edges`) to a picture of colours or
//! of numbers, and written whole or not at all (`output`).
//!
//! With the feature `view` a model is shown in a window (`viewer`).
//!
//! The exit code is 0 if all pictures are written, 1 if one is not, and 2 if the options are wrong.

use std::io::{IsTerminal as _, Write as _};
use std::process::ExitCode;

use clap::{CommandFactory as _, Parser as _};
use clap_mangen::Man;
use indicatif::{ProgressBar, ProgressStyle};
use rayon::prelude::*;

mod options;
mod view;
mod edges;
mod looks;
mod pixels;
mod draw;
mod output;
mod job;
#[cfg(feature = "view")]
mod viewer;

use job::Job;
use options::{Command, Options, ViewOptions};

/// The exit code for options that are wrong, that of `clap`.
const USAGE: u8 = 2;

/// The exit code for what cannot be done.
#[cfg(feature = "view")]
const FAILED: u8 = 1;

fn main() -> ExitCode {
    let options = Options::parse();
    if let Some(code) = print_about(&options) {
        return code;
    }
    if let Some(Command::View(view)) = &options.command {
        return end(show(view));
    }
    let jobs = match options.check().and_then(|()| Job::all(&options)) {
        Ok(jobs) => jobs,
        Err(sentence) => return end(Err((USAGE, sentence))),
    };
    let bar = progress(&options, &jobs);
    let run = |job: &Job| {
        let is_done = run(job, &options, &bar);
        if jobs.len() > 1 {
            bar.inc(1);
        }
        is_done
    };
    let done: Vec<bool> = if jobs.len() > 1 {
        jobs.par_iter().map(run).collect()
    } else {
        jobs.iter().map(run).collect()
    };
    bar.finish_and_clear();
    if done.iter().all(|&done| done) { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// Shows a model in a window until it is closed.
#[cfg(feature = "view")]
fn show(options: &ViewOptions) -> Result<(), (u8, String)> {
    viewer::show(options).map_err(|sentence| (FAILED, sentence))
}

#[cfg(not(feature = "view"))]
fn show(_: &ViewOptions) -> Result<(), (u8, String)> {
    let sentence = "this build of polyscan opens no windows: install it by \
                    `cargo install polyscan-cli --features view`";
    Err((USAGE, sentence.into()))
}

/// The exit code of what was done, after what went wrong is said.
fn end(result: Result<(), (u8, String)>) -> ExitCode {
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err((code, sentence)) => {
            eprintln!("error: {sentence}");
            ExitCode::from(code)
        }
    }
}

/// Prints what is asked for about the tool itself.
fn print_about(options: &Options) -> Option<ExitCode> {
    let mut text = Vec::new();
    if let Some(shell) = options.completions {
        clap_complete::generate(shell, &mut Options::command(), "polyscan", &mut text);
    } else if options.man {
        write_man_page(&mut text).expect("a vector takes all that is written");
    } else {
        return None;
    }
    Some(match std::io::stdout().write_all(&text) {
        Ok(()) => ExitCode::SUCCESS,
        Err(_) => ExitCode::FAILURE,
    })
}

/// One page for the tool and its window.
fn write_man_page(page: &mut Vec<u8>) -> std::io::Result<()> {
    let mut command = Options::command();
    command.build();
    let window = command.find_subcommand("view").cloned();
    let tool = Man::new(command);
    tool.render_title(page)?;
    tool.render_name_section(page)?;
    tool.render_synopsis_section(page)?;
    tool.render_description_section(page)?;
    tool.render_options_section(page)?;
    if let Some(window) = window.map(Man::new) {
        let mut sections = Vec::new();
        window.render_synopsis_section(&mut sections)?;
        window.render_description_section(&mut sections)?;
        window.render_options_section(&mut sections)?;
        // Within a section of the page.
        let sections = String::from_utf8_lossy(&sections).replace(".SH ", ".SS ");
        write!(page, ".SH \"POLYSCAN VIEW\"\n{sections}")?;
    }
    tool.render_extra_section(page)?;
    tool.render_version_section(page)
}

/// A bar on a terminal for what takes its time, and nothing elsewhere.
fn progress(options: &Options, jobs: &[Job]) -> ProgressBar {
    let length = if jobs.len() > 1 { jobs.len() } else { options.turntable.map_or(0, usize::from) };
    if length == 0 || options.quiet || !std::io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::new(length as u64);
    match ProgressStyle::with_template("{bar:40} {pos}/{len} pictures, {eta} left") {
        Ok(style) => bar.with_style(style),
        Err(_) => bar,
    }
}

/// Draws one picture; says on one line what came of it, and whether it was written.
fn run(job: &Job, options: &Options, bar: &ProgressBar) -> bool {
    let result = job.run(options, bar);
    bar.suspend(|| match (&result, options.json) {
        (_, true) => say(&job.json(&result)),
        (Ok(report), false) => {
            if !options.quiet {
                for warning in &report.warnings {
                    eprintln!("warning: {warning}");
                }
                if !job.is_to_stdout() {
                    say(&report.line(job));
                }
            }
        }
        (Err(sentence), false) => eprintln!("error: {sentence}"),
    });
    result.is_ok()
}

/// A line on the standard output. If nobody reads it, the picture is written all the same.
fn say(line: &str) {
    let _ = writeln!(std::io::stdout().lock(), "{line}");
}
