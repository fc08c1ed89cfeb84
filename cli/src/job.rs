//! One model to one picture: loaded, drawn and written.

use std::borrow::Cow;
use std::collections::HashSet;
use std::io;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::time::Instant;

use indicatif::ProgressBar;
use polyscan::camera::Sphere;
use polyscan::color::Color as _;
use polyscan::formats::{Format, Loaded};
use polyscan::glam::{Vec3, Vec4};
use polyscan::render::PngFile;
use polyscan::texture::MipFilter;
use polyscan::{Framebuffer, Viewport};
use serde_json::json;

use crate::draw::{Lines, Renderers, Scene, Seen, Shot, Style, Vertices, size_error};
use crate::options::{Options, check_output};
use crate::output::{Picture, Pixels, is_stdout, write};
use crate::pixels::encode;
use crate::view::{View, sphere_of, turns};

/// The endings of names that are models, in folders.
const ENDINGS: [&str; 5] = ["obj", "stl", "ply", "gltf", "glb"];

/// A model, and the picture that it becomes.
pub(crate) struct Job {
    model: PathBuf,
    output: PathBuf,
    /// The rows of the picture that are drawn.
    rows: Range<u32>,
}

/// What was done.
pub(crate) struct Report {
    format: Format,
    faces: usize,
    vertices: usize,
    materials: usize,
    textures: usize,
    origin: [f64; 3],
    bounds: Option<(Vec3, Vec3)>,
    size: (u32, u32),
    /// The least and the greatest distance of a depth picture.
    range: Option<(f32, f32)>,
    pub(crate) warnings: Vec<String>,
    load_seconds: f64,
    draw_seconds: f64,
}

impl Job {
    /// The jobs of all models; or what is wrong with the names.
    pub(crate) fn all(options: &Options) -> Result<Vec<Self>, String> {
        let output = options.output.clone().unwrap_or_default();
        let mut models = Vec::new();
        let mut has_folder = false;
        for model in &options.models {
            if model.is_dir() {
                has_folder = true;
                models.extend(models_in(model)?);
            } else {
                models.push(model.clone());
            }
        }
        if models.len() == 1 && !has_folder && !output.is_dir() {
            let model = models.remove(0);
            options.check_rows()?;
            if !is_stdout(&output) {
                check_output(&output, options.turntable.is_some(), options.size)?;
            } else if options.json {
                return Err("the picture and --json cannot both go to the standard output".into());
            }
            return Ok(vec![Self { model, output, rows: options.rows() }]);
        }
        if is_stdout(&output) || models.iter().any(|model| is_stdout(model)) {
            return Err("several models cannot go to or come from one stream: name files".into());
        }
        if models.is_empty() {
            return Err("there are no models in the folder (obj, stl, ply, gltf, glb)".into());
        }
        let mut taken = HashSet::new();
        let mut jobs = Vec::new();
        for model in models {
            // `a.obj` and `a.stl` become `a.png` and `a.stl.png`.
            let stem = model.file_stem().unwrap_or_default().to_owned();
            let whole = model.file_name().unwrap_or_default().to_owned();
            let name = [stem, whole].into_iter().map(|mut name| {
                name.push(".png");
                name
            });
            let name = name.into_iter().find(|name| taken.insert(name.clone()));
            let name = name.ok_or_else(|| {
                format!("two models would become one picture: {}", model.display())
            })?;
            jobs.push(Self { model, output: output.join(name), rows: 0..options.size.1 });
        }
        if let Some(shard) = options.shard {
            let mut item = 0..;
            jobs.retain(|_| item.next().is_some_and(|item| shard.has(item)));
        }
        std::fs::create_dir_all(&output)
            .map_err(|error| format!("cannot make the folder {}: {error}", output.display()))?;
        Ok(jobs)
    }

    pub(crate) fn is_to_stdout(&self) -> bool {
        is_stdout(&self.output)
    }

    /// Loads, draws and writes; an error is a sentence.
    pub(crate) fn run(&self, options: &Options, bar: &ProgressBar) -> Result<Report, String> {
        let start = Instant::now();
        let loader = options.files.loader();
        let loaded = if is_stdout(&self.model) {
            loader.read(io::stdin().lock(), "standard input")
        } else {
            loader.load(&self.model)
        };
        let mut loaded = loaded.map_err(|error| error.to_string())?;
        let filtered = loaded.model.with_mip_filter(MipFilter::Anisotropic { probes: 16 });
        loaded.model = filtered.map_err(|error| error.to_string())?;
        let load_seconds = start.elapsed().as_secs_f64();

        let start = Instant::now();
        let mut drawing = Drawing::new(&loaded, (options, self.rows.clone()), bar);
        let size = if options.is_streamed() {
            drawing.stream(&self.output)?;
            (options.size.0, self.rows.len() as u32)
        } else {
            let picture = drawing.picture()?;
            write(&picture, &self.output)?;
            (picture.width, picture.height)
        };
        let range = drawing.range;
        let Loaded { model, format, warnings } = loaded;
        Ok(Report {
            format,
            faces: model.face_count(),
            vertices: model.vertices.len(),
            materials: model.materials.len(),
            textures: model.textures.len(),
            origin: model.origin.to_array(),
            bounds: model.bounds(),
            size,
            range,
            warnings,
            load_seconds,
            draw_seconds: start.elapsed().as_secs_f64(),
        })
    }

    /// What was done, as a line of JSON.
    pub(crate) fn json(&self, result: &Result<Report, String>) -> String {
        let model = self.model.to_string_lossy();
        let report = match result {
            Ok(report) => report,
            Err(sentence) => return json!({ "model": model, "error": sentence }).to_string(),
        };
        let bounds = report.bounds.map(|(low, high)| [low.to_array(), high.to_array()]);
        json!({
            "model": model,
            "output": self.output.to_string_lossy(),
            "format": format!("{:?}", report.format).to_lowercase(),
            "faces": report.faces,
            "vertices": report.vertices,
            "materials": report.materials,
            "textures": report.textures,
            "origin": report.origin,
            "bounds": bounds,
            "size": [report.size.0, report.size.1],
            "rows": [self.rows.start, self.rows.end],
            "depth_range": report.range.map(|(near, far)| [near, far]),
            "warnings": report.warnings,
            "load_seconds": report.load_seconds,
            "draw_seconds": report.draw_seconds,
        })
        .to_string()
    }
}

impl Report {
    /// What was done, as a line for people.
    pub(crate) fn line(&self, job: &Job) -> String {
        let (width, height) = self.size;
        let seconds = self.load_seconds + self.draw_seconds;
        format!(
            "wrote {}: {} faces, {width} x {height} pixels, {seconds:.2} s",
            job.output.display(),
            self.faces
        )
    }
}

/// The models of a folder, in the order of their names.
fn models_in(folder: &Path) -> Result<Vec<PathBuf>, String> {
    let unreadable = |error| format!("cannot read the folder {}: {error}", folder.display());
    let mut models = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(unreadable)? {
        let path = entry.map_err(unreadable)?.path();
        let ending = path.extension().map(|ending| ending.to_string_lossy().to_lowercase());
        if ending.is_some_and(|ending| ENDINGS.contains(&ending.as_str())) && path.is_file() {
            models.push(path);
        }
    }
    models.sort();
    Ok(models)
}

/// A model that is drawn by the options.
struct Drawing<'a> {
    loaded: &'a Loaded,
    scene: Scene<'a>,
    sphere: Sphere,
    options: &'a Options,
    /// The rows of the picture that are drawn.
    rows: Range<u32>,
    bar: &'a ProgressBar,
    renderers: Renderers,
    /// The least and the greatest distance of a depth picture.
    range: Option<(f32, f32)>,
}

impl<'a> Drawing<'a> {
    fn new(
        loaded: &'a Loaded,
        (options, rows): (&'a Options, Range<u32>),
        bar: &'a ProgressBar,
    ) -> Self {
        let scene = Scene::new(&loaded.model);
        let (sphere, renderers) = (sphere_of(&loaded.model), Renderers::default());
        Self { loaded, scene, sphere, options, rows, bar, renderers, range: None }
    }

    /// Does something with a view. Displacement maps are geometry there, unless the faces' own lines are drawn.
    fn with_shot<R>(
        &self,
        turn: (f32, f32),
        act: impl FnOnce(&Shot<'_>) -> Result<R, String>,
    ) -> Result<R, String> {
        let Loaded { model, format, .. } = self.loaded;
        let Options { wireframe, edges, size: (width, height), .. } = *self.options;
        let view = View::of((model, self.sphere), *format, self.options, turn);
        let viewport = Viewport::new(width, height).map_err(size_error)?;
        let shot =
            |scene: &Scene<'_>| act(&Shot::new(scene, &model.textures, view, Vertices::default()));
        if wireframe || edges {
            return shot(&self.scene);
        }
        match model.displaced(view.clip_from_object, viewport, 1.0) {
            Cow::Borrowed(_) => shot(&self.scene),
            Cow::Owned(diced) => shot(&Scene::new(&diced)),
        }
    }

    fn picture(&mut self) -> Result<Picture, String> {
        let (width, height) = (self.options.size.0, self.rows.len() as u32);
        if let Some(count) = self.options.views {
            return self.sheet(count);
        }
        let pixels = if let Some(count) = self.options.turntable {
            let mut frames = Vec::new();
            for i in 0..count {
                frames.push(self.colors((360.0 * f32::from(i) / f32::from(count), 0.0))?);
                self.bar.inc(u64::from(!self.bar.is_hidden()));
            }
            Pixels::Colors(frames)
        } else if self.options.depth {
            self.depths()?
        } else if self.options.ids || self.options.normals {
            Pixels::Numbers(self.numbers((0.0, 0.0))?)
        } else {
            Pixels::Colors(vec![self.colors((0.0, 0.0))?])
        };
        Ok(Picture { width, height, pixels })
    }

    /// The colours of a view, of four bytes a pixel.
    fn colors(&mut self, turn: (f32, f32)) -> Result<Vec<u8>, String> {
        let mut bytes = Vec::with_capacity(self.options.size.0 as usize * self.rows.len() * 4);
        self.pixels(turn, |pixels| {
            encode(pixels, &mut bytes);
            Ok(())
        })?;
        Ok(bytes)
    }

    /// Draws a view and hands over whole rows of it.
    fn pixels(
        &mut self,
        turn: (f32, f32),
        sink: impl FnMut(&[Vec4]) -> Result<(), String>,
    ) -> Result<(), String> {
        let Options { samples, background, wireframe, edges, size, .. } = *self.options;
        let mut renderers = std::mem::take(&mut self.renderers);
        let style = Style {
            method: self.scene.method(),
            samples,
            background: background.0,
            lines: Lines { wireframe, edges },
        };
        self.with_shot(turn, |shot| {
            shot.pixels(&mut renderers, (size, self.rows.clone()), style, sink)
        })?;
        self.renderers = renderers;
        Ok(())
    }

    fn seen(&self, turn: (f32, f32)) -> Result<Framebuffer<Seen>, String> {
        let (size, rows) = (self.options.size, self.rows.clone());
        self.with_shot(turn, |shot| shot.seen((size, rows)).map_err(size_error))
    }

    /// The numbers or normals of a view, of three bytes a pixel.
    fn numbers(&self, turn: (f32, f32)) -> Result<Vec<u8>, String> {
        let channel = |n: f32| (127.5 * (n + 1.0)).round() as u8;
        let normal = |seen: &Seen| match seen.face {
            0 => [0; 3],
            _ => seen.normal.to_array().map(channel),
        };
        let id = |seen: &Seen| {
            let [r, g, b, _] = seen.face.to_le_bytes();
            [r, g, b]
        };
        let seen = self.seen(turn)?;
        let is_id = self.options.ids;
        Ok(seen
            .color()
            .iter()
            .flat_map(|seen| if is_id { id(seen) } else { normal(seen) })
            .collect())
    }

    fn depths(&mut self) -> Result<Pixels, String> {
        let seen = self.seen((0.0, 0.0))?;
        // In a parallel projection all w are 1; depth itself is the distance there.
        let distances = || seen.color().iter().zip(seen.depth());
        let is_flat = distances().all(|(seen, _)| seen.face == 0 || seen.distance == 1.0);
        let distance = |seen: &Seen, depth: f32| if is_flat { depth } else { seen.distance };
        let there = distances().filter(|(seen, _)| seen.face > 0);
        let (near, far) = there.fold((f32::INFINITY, f32::NEG_INFINITY), |(near, far), (s, &d)| {
            (near.min(distance(s, d)), far.max(distance(s, d)))
        });
        if near <= far {
            self.range = Some((near, far));
        }
        let scale = if far > near { 65_534.0 / (far - near) } else { 0.0 };
        let code = |(seen, &depth): (&Seen, &f32)| match seen.face {
            0 => 0,
            _ => 1 + ((distance(seen, depth) - near) * scale).round() as u16,
        };
        Ok(Pixels::Depths(distances().map(code).collect()))
    }

    /// Views side by side, in a sheet about as wide as it is high.
    fn sheet(&mut self, count: u32) -> Result<Picture, String> {
        let (width, height) = self.options.size;
        let columns = (1..=count).find(|columns| columns * columns >= count).unwrap_or(1);
        let rows = count.div_ceil(columns);
        let channels = if self.options.ids || self.options.normals { 3 } else { 4 };
        let (whole, high) = (width * columns, height * rows);
        let bytes = u64::from(whole) * u64::from(high) * channels as u64;
        if bytes > 1 << 32 {
            return Err(format!(
                "a sheet of {whole} x {high} pixels is too large: choose a smaller --size"
            ));
        }
        let blank = match self.options.background.0.to_srgb8() {
            _ if channels == 3 => vec![0; 3],
            color => color.to_vec(),
        };
        let mut sheet = blank.repeat(whole as usize * high as usize);
        let line = width as usize * channels;
        for (i, (yaw, pitch)) in (0..count).zip(turns(count)) {
            // From the front, whatever the options' own view.
            let turn = (yaw - self.options.eye.yaw, pitch - self.options.eye.pitch);
            let cell = if channels == 3 { self.numbers(turn)? } else { self.colors(turn)? };
            let (left, top) = ((i % columns) as usize * line, (i / columns * height) as usize);
            for (y, pixels) in cell.chunks_exact(line).enumerate() {
                let start = (top + y) * whole as usize * channels + left;
                sheet[start..start + line].copy_from_slice(pixels);
            }
        }
        let pixels =
            if channels == 3 { Pixels::Numbers(sheet) } else { Pixels::Colors(vec![sheet]) };
        Ok(Picture { width: whole, height: high, pixels })
    }

    /// Draws row by row into the file: never the whole picture in memory.
    fn stream(&mut self, output: &Path) -> Result<(), String> {
        if is_stdout(output) {
            return Err("a picture of this size needs a file to be written to".into());
        }
        let Options { samples, background, wireframe, edges, .. } = *self.options;
        let (width, height) = self.options.size;
        let rows = self.rows.len() as u32;
        let mut file = PngFile::new(output, width, rows).map_err(|error| error.to_string())?;
        let mut write = |row: &[Vec4]| file.write_row(row).map_err(|error| error.to_string());
        if rows < height || wireframe || edges {
            self.pixels((0.0, 0.0), |pixels| {
                pixels.chunks_exact(width as usize).try_for_each(&mut write)
            })?;
            return file.finish().map_err(|error| error.to_string());
        }
        let viewport = Viewport::new(width * samples, height * samples).map_err(size_error)?;
        let mut sums = vec![Vec4::ZERO; width as usize];
        let mut sink = |row: u32, colors: &[Vec4]| {
            for (sum, colors) in sums.iter_mut().zip(colors.chunks_exact(samples as usize)) {
                *sum += colors.iter().sum::<Vec4>();
            }
            if !(row + 1).is_multiple_of(samples) {
                return Ok(());
            }
            for sum in &mut sums {
                *sum *= 1.0 / (samples * samples) as f32;
            }
            write(&sums)?;
            sums.fill(Vec4::ZERO);
            Ok(())
        };
        self.with_shot((0.0, 0.0), |shot| shot.stream(viewport, background.0, &mut sink))?;
        file.finish().map_err(|error| error.to_string())
    }
}
