//! The order of the house: what holds of the sources as texts, whatever the code does.
//!
//! - No circle of imports exists between the files of `src`, so that they can be read one after the
//!   other. A file imports another if it names something that is defined there, or re-exported
//!   there, in a `use` or in a path. A parent and its child count like any two files. What `mod`
//!   declares is not imported by that.
//! - The documentation of `lib.rs` names the module of every file, and the modules that `lib.rs`
//!   declares in the order in which it declares them.
//! - No function is longer than a screen, and none has more arguments than one can remember.
//!
//! Code that is compiled for tests alone is read past, and so are the bodies of `macro_rules!`.

use std::collections::{BTreeMap, BTreeSet, HashMap, VecDeque};
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use proc_macro2::{TokenStream, TokenTree};
use quote::ToTokens;
use syn::parse::{ParseStream, Parser as _};
use syn::punctuated::Punctuated;
use syn::spanned::Spanned as _;
use syn::visit::{self, Visit};
use syn::{Attribute, Item, Meta, Token, UseTree};

/// The directory that has `src` in it.
const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/..");

/// The most lines of a function, from `fn` to the closing brace.
const MAX_LINES: usize = 60;

/// The most arguments of a function, `self` among them.
const MAX_ARGUMENTS: usize = 7;

// ---------------------------------------------------------------------------------- the sources

/// A module as the names on the way to it: none for `lib.rs`, `render` and `raster` for
/// `render/raster.rs`.
type Module = Vec<String>;

/// The files of a crate, by their modules.
struct Sources {
    files: BTreeMap<Module, Source>,
}

struct Source {
    /// The name below the root, such as `src/render/raster.rs`.
    name: String,
    text: String,
    syntax: syn::File,
}

impl Sources {
    /// The files of `src`.
    fn read() -> Self {
        let mut texts = Vec::new();
        read_directory(&Path::new(ROOT).join("src"), "", &mut texts);
        Self::new(texts)
    }

    /// Files by their names below `src` and their texts. Files that are modules for tests alone are
    /// left out.
    fn new(texts: impl IntoIterator<Item = (String, String)>) -> Self {
        let mut files = BTreeMap::new();
        for (name, text) in texts {
            let name = format!("src/{name}");
            let syntax = syn::parse_file(&text).unwrap_or_else(|e| panic!("{name}: {e}"));
            files.insert(module_of(&name), Source { name, text, syntax });
        }
        let mut test_modules = Vec::new();
        for (module, source) in &files {
            for item in &source.syntax.items {
                if let Item::Mod(child) = item
                    && is_for_tests(item)
                {
                    test_modules.push(within(module, [child.ident.to_string()]));
                }
            }
        }
        files.retain(|module, _| !test_modules.iter().any(|test| module.starts_with(test)));
        Self { files }
    }

    /// The file that a path leads to, followed module by module as far as there are files.
    fn file_of(&self, path: &[String]) -> Option<&Source> {
        (0..=path.len()).rev().find_map(|len| self.files.get(&path[..len]))
    }

    fn root(&self) -> &Source {
        self.files.get(&Vec::new()).expect("a lib.rs")
    }
}

fn read_directory(directory: &Path, prefix: &str, texts: &mut Vec<(String, String)>) {
    let entries = fs::read_dir(directory).expect("a directory of sources");
    for entry in entries {
        let path = entry.expect("an entry of the directory").path();
        let name = path.file_name().expect("a name").to_str().expect("a name in UTF-8");
        if path.is_dir() {
            read_directory(&path, &format!("{prefix}{name}/"), texts);
        } else if name.ends_with(".rs") {
            texts.push((format!("{prefix}{name}"), fs::read_to_string(&path).expect("a source")));
        }
    }
}

fn module_of(name: &str) -> Module {
    let name = name.strip_prefix("src/").expect("a file of src");
    let name = name.strip_suffix(".rs").expect("a Rust file");
    let name = name.strip_suffix("/mod").unwrap_or(name);
    if name == "lib" { Vec::new() } else { name.split('/').map(str::to_owned).collect() }
}

fn within(module: &[String], rest: impl IntoIterator<Item = String>) -> Module {
    module.iter().cloned().chain(rest).collect()
}

/// Whether a piece of code has an attribute by which it is compiled for tests alone.
fn is_for_tests(code: &impl ToTokens) -> bool {
    let outer = |input: ParseStream<'_>| {
        let attributes = input.call(Attribute::parse_outer)?;
        input.parse::<TokenStream>()?;
        Ok(attributes)
    };
    let attributes = outer.parse2(code.to_token_stream()).expect("attributes before the code");
    attributes.iter().any(|attribute| {
        attribute.path().is_ident("test")
            || attribute.path().is_ident("cfg")
                && attribute.parse_args().is_ok_and(|condition| is_test(&condition))
    })
}

/// Whether a condition of `cfg` can hold in tests alone.
fn is_test(condition: &Meta) -> bool {
    match condition {
        Meta::Path(path) => path.is_ident("test"),
        Meta::List(list) => {
            let parts = list.parse_args_with(Punctuated::<Meta, Token![,]>::parse_terminated);
            let Ok(parts) = parts else { return false };
            list.path.is_ident("all") && parts.iter().any(is_test)
                || list.path.is_ident("any") && !parts.is_empty() && parts.iter().all(is_test)
        }
        Meta::NameValue(_) => false,
    }
}

/// The visits that read past what is for tests, alike for all visitors.
macro_rules! without_tests {
    ($($visit:ident: $type:ty),* $(,)?) => {$(
        fn $visit(&mut self, code: &'ast $type) {
            if !is_for_tests(code) {
                visit::$visit(self, code);
            }
        }
    )*};
}

// ---------------------------------------------------------------------------------- the imports

/// Where a file imports another, and by which path.
struct Arrow {
    line: usize,
    path: String,
}

/// The files that each file imports, by their names.
type Arrows = BTreeMap<String, BTreeMap<String, Arrow>>;

fn arrows(sources: &Sources) -> Arrows {
    let mut arrows = Arrows::new();
    for (module, source) in &sources.files {
        let mut imports = Imports {
            sources,
            source,
            module: module.clone(),
            names: HashMap::new(),
            found: BTreeMap::new(),
        };
        // The first time for the names that `use` brings, which may be used before.
        imports.visit_file(&source.syntax);
        imports.visit_file(&source.syntax);
        arrows.insert(source.name.clone(), imports.found);
    }
    arrows
}

/// Collects the imports of a file.
struct Imports<'s> {
    sources: &'s Sources,
    source: &'s Source,
    /// The module that is being read: the file's, or one inside it.
    module: Module,
    /// What the names stand for that `use` brings into the file, wherever in it.
    names: HashMap<String, Module>,
    found: BTreeMap<String, Arrow>,
}

impl Imports<'_> {
    /// The path from the crate's root; `None` if it leads to another crate, or nowhere.
    fn resolve(&self, path: &[String]) -> Option<Module> {
        let (first, mut rest) = path.split_first()?;
        let mut base = match first.as_str() {
            "crate" => Vec::new(),
            "self" => self.module.clone(),
            "super" => self.module.split_last()?.1.to_vec(),
            name => {
                let child = within(&self.module, [name.to_owned()]);
                if self.sources.files.contains_key(&child) {
                    child
                } else {
                    self.names.get(name)?.clone()
                }
            }
        };
        while let Some((first, others)) = rest.split_first()
            && first == "super"
        {
            base.pop()?;
            rest = others;
        }
        Some(within(&base, rest.iter().cloned()))
    }

    fn import(&mut self, path: &[String], line: usize) {
        let Some(target) = self.resolve(path) else { return };
        let Some(file) = self.sources.file_of(&target) else { return };
        if file.name == self.source.name {
            return;
        }
        if self.found.get(&file.name).is_none_or(|known| line < known.line) {
            self.found.insert(file.name.clone(), Arrow { line, path: path.join("::") });
        }
    }

    fn import_tree(&mut self, path: &mut Vec<String>, tree: &UseTree) {
        let (name, new_name) = match tree {
            UseTree::Path(part) => {
                path.push(part.ident.to_string());
                self.import_tree(path, &part.tree);
                path.pop();
                return;
            }
            UseTree::Group(group) => {
                for tree in &group.items {
                    self.import_tree(path, tree);
                }
                return;
            }
            UseTree::Glob(glob) => return self.import(path, glob.span().start().line),
            UseTree::Name(name) => (&name.ident, &name.ident),
            UseTree::Rename(name) => (&name.ident, &name.rename),
        };
        let line = name.span().start().line;
        // `use a::{self}` imports `a`.
        let is_self = name == "self" && !path.is_empty();
        let new_name = if is_self && new_name == "self" {
            path[path.len() - 1].clone()
        } else {
            new_name.to_string()
        };
        if !is_self {
            path.push(name.to_string());
        }
        self.import(path, line);
        if let Some(target) = self.resolve(path) {
            self.names.entry(new_name).or_insert(target);
        }
        if !is_self {
            path.pop();
        }
    }

    /// What looks like a path in the arguments of a macro, which need not be Rust.
    fn import_tokens(&mut self, tokens: TokenStream) {
        let tokens: Vec<_> = tokens.into_iter().collect();
        let is_colon = |i: usize| match tokens.get(i) {
            Some(TokenTree::Punct(mark)) => mark.as_char() == ':',
            _ => false,
        };
        let is_colons = |i: usize| is_colon(i) && is_colon(i + 1);
        let mut next = 0;
        while next < tokens.len() {
            let first = next;
            next += 1;
            match &tokens[first] {
                TokenTree::Group(group) => self.import_tokens(group.stream()),
                TokenTree::Ident(ident) => {
                    let mut path = vec![ident.to_string()];
                    while is_colons(next)
                        && let Some(TokenTree::Ident(ident)) = tokens.get(next + 2)
                    {
                        path.push(ident.to_string());
                        next += 3;
                    }
                    let is_rest = first >= 2 && is_colons(first - 2);
                    if path.len() > 1 && !is_rest {
                        self.import(&path, ident.span().start().line);
                    }
                }
                TokenTree::Punct(_) | TokenTree::Literal(_) => {}
            }
        }
    }
}

impl<'ast> Visit<'ast> for Imports<'_> {
    without_tests! {
        visit_item: Item,
        visit_impl_item: syn::ImplItem,
        visit_trait_item: syn::TraitItem,
        visit_stmt: syn::Stmt,
        visit_field: syn::Field,
        visit_variant: syn::Variant,
        visit_arm: syn::Arm,
    }

    fn visit_item_mod(&mut self, item: &'ast syn::ItemMod) {
        self.module.push(item.ident.to_string());
        visit::visit_item_mod(self, item);
        self.module.pop();
    }

    fn visit_item_use(&mut self, item: &'ast syn::ItemUse) {
        if item.leading_colon.is_none() {
            self.import_tree(&mut Vec::new(), &item.tree);
        }
    }

    fn visit_path(&mut self, path: &'ast syn::Path) {
        if path.leading_colon.is_none() && path.segments.len() > 1 {
            let names: Vec<_> = path.segments.iter().map(|part| part.ident.to_string()).collect();
            self.import(&names, path.span().start().line);
        }
        visit::visit_path(self, path);
    }

    fn visit_macro(&mut self, invocation: &'ast syn::Macro) {
        if !invocation.path.is_ident("macro_rules") {
            visit::visit_macro(self, invocation);
            self.import_tokens(invocation.tokens.clone());
        }
    }

    // Documentation, and the `crate` in `pub(crate)`, import nothing.
    fn visit_attribute(&mut self, _: &'ast Attribute) {}
    fn visit_vis_restricted(&mut self, _: &'ast syn::VisRestricted) {}
}

// ---------------------------------------------------------------------------------- the circles

/// Files each of which can be reached from each other by imports, all such in lists as long as
/// possible.
///
/// `lib.rs` declares everything and may import everything, so each file that imports `lib.rs` makes
/// a circle with it, and other files are none the worse for that.
fn circles(arrows: &Arrows) -> Vec<Vec<String>> {
    const LIB: &str = "src/lib.rs";
    let mut circles = Vec::new();
    for (file, targets) in arrows {
        if targets.contains_key(LIB) {
            circles.push(vec![file.clone(), LIB.to_owned()]);
        }
    }
    let reached: BTreeMap<&str, BTreeSet<&str>> =
        arrows.keys().map(|file| (file.as_str(), reachable(arrows, file))).collect();
    let mut done = BTreeSet::from([LIB]);
    for (file, targets) in &reached {
        if !targets.contains(file) || done.contains(file) {
            continue;
        }
        let members: Vec<&str> =
            targets.iter().copied().filter(|other| reached[other].contains(file)).collect();
        done.extend(&members);
        circles.push(members.into_iter().map(str::to_owned).collect());
    }
    circles
}

/// The files that a file imports, and those that they import, and so on, but not by `lib.rs`.
fn reachable<'a>(arrows: &'a Arrows, file: &str) -> BTreeSet<&'a str> {
    let mut reached = BTreeSet::new();
    let mut ahead = vec![file];
    while let Some(file) = ahead.pop() {
        for target in arrows[file].keys() {
            if target != "src/lib.rs" && reached.insert(target.as_str()) {
                ahead.push(target);
            }
        }
    }
    reached
}

/// The shortest way from a file of a circle to itself, the shortest of all its files.
fn shortest_way<'a>(arrows: &'a Arrows, circle: &'a [String]) -> Vec<&'a str> {
    let way_from = |start: &'a String| {
        let mut ways = VecDeque::from([vec![start.as_str()]]);
        let mut reached = BTreeSet::new();
        while let Some(way) = ways.pop_front() {
            for target in arrows[way[way.len() - 1]].keys() {
                let longer = || way.iter().copied().chain([target.as_str()]).collect();
                if target == start {
                    return Some(longer());
                }
                if circle.contains(target) && reached.insert(target) {
                    ways.push_back(longer());
                }
            }
        }
        None
    };
    circle.iter().filter_map(way_from).min_by_key(Vec::len).expect("a way round the circle")
}

/// The circles in words, each arrow with a line that makes it.
fn describe(arrows: &Arrows, circles: &[Vec<String>]) -> String {
    let mut words = String::new();
    for circle in circles {
        let _ = writeln!(words, "\nA circle of {} files:", circle.len());
        if let [file, lib] = &circle[..]
            && lib == "src/lib.rs"
        {
            let Arrow { line, path } = &arrows[file][lib];
            let _ = writeln!(words, "  {file}:{line} imports {lib}, which has them all: {path}");
            continue;
        }
        if circle.len() > 2 {
            let _ =
                writeln!(words, "  the shortest: {}", shortest_way(arrows, circle).join(" -> "));
        }
        for file in circle {
            for (target, Arrow { line, path }) in &arrows[file] {
                if circle.contains(target) {
                    let _ = writeln!(words, "  {file}:{line} imports {target}: {path}");
                }
            }
        }
    }
    words
}

#[test]
fn imports_have_no_circles() {
    let arrows = arrows(&Sources::read());
    let circles = circles(&arrows);
    assert!(
        circles.is_empty(),
        "files import each other in {} circles. Move what they share into a file below them.\n{}",
        circles.len(),
        describe(&arrows, &circles),
    );
}

// ------------------------------------------------------------------------------------- the tour

/// What stands in backticks or in the brackets of links in the documentation of a file, code blocks
/// left out, as paths of modules: `crate::render` as `render`, and `render/raster.rs` as
/// `render::raster`.
fn names_in_docs(text: &str) -> Vec<String> {
    let mut is_code = false;
    let mut names = Vec::new();
    for line in text.lines().filter_map(|line| line.strip_prefix("//!")) {
        if line.trim_start().starts_with("```") {
            is_code = !is_code;
        } else if !is_code {
            names.extend(names_in_line(line).into_iter().map(as_module));
        }
    }
    names
}

/// What stands in backticks or in brackets, from left to right.
fn names_in_line(line: &str) -> Vec<&str> {
    let mut names = Vec::new();
    let mut rest = line;
    while let Some(start) = rest.find(['`', '[']) {
        let end = if rest[start..].starts_with('`') { '`' } else { ']' };
        let inside = &rest[start + 1..];
        let Some(len) = inside.find(end) else { break };
        names.push(inside[..len].trim_matches('`'));
        rest = &inside[len + 1..];
    }
    names
}

fn as_module(name: &str) -> String {
    let name = ["mod@", "crate::", "polyscan::", "self::", "src/"]
        .into_iter()
        .fold(name, |name, prefix| name.strip_prefix(prefix).unwrap_or(name));
    name.strip_suffix(".rs").unwrap_or(name).replace('/', "::")
}

/// What the documentation of `lib.rs` lacks.
fn gaps_in_tour(sources: &Sources) -> Vec<String> {
    let lib = sources.root();
    let names = names_in_docs(&lib.text);
    let modules: Vec<String> =
        sources.files.keys().filter(|path| !path.is_empty()).map(|path| path.join("::")).collect();
    // The whole path, or the end of it if no other module has that end.
    let is_name_of = |name: &str, module: &str| {
        let ends_so = |module: &str| module == name || module.ends_with(&format!("::{name}"));
        module == name || ends_so(module) && modules.iter().filter(|m| ends_so(m)).count() == 1
    };
    let mut gaps = Vec::new();
    for module in &modules {
        if !names.iter().any(|name| is_name_of(name, module)) {
            gaps.push(format!("`{module}` is not named"));
        }
    }
    let mut rest = &names[..];
    let mut previous = None;
    for item in &lib.syntax.items {
        let Item::Mod(child) = item else { continue };
        let module = child.ident.to_string();
        if is_for_tests(item) || gaps.contains(&format!("`{module}` is not named")) {
            continue;
        }
        match rest.iter().position(|name| is_name_of(name, &module)) {
            Some(i) => rest = &rest[i + 1..],
            None => gaps.push(format!(
                "`{module}` is not named after `{}`, as it is declared",
                previous.expect("only a later one can be out of order"),
            )),
        }
        previous = Some(module);
    }
    gaps
}

#[test]
fn the_tour_names_every_module() {
    let gaps = gaps_in_tour(&Sources::read());
    assert!(
        gaps.is_empty(),
        "the documentation of src/lib.rs names every module, in backticks or as a link, but \
         {} things are wrong:\n{}",
        gaps.len(),
        gaps.join("\n"),
    );
}

// -------------------------------------------------------------------------------- the functions

/// Collects the functions that are too long or have too many arguments.
struct Functions<'s> {
    file: &'s str,
    found: Vec<String>,
}

impl Functions<'_> {
    fn check(&mut self, signature: &syn::Signature, body: Option<&syn::Block>) {
        let (file, name) = (self.file, &signature.ident);
        let first = signature.fn_token.span().start().line;
        let last = body.map_or(first, |body| body.brace_token.span.close().end().line);
        let (lines, arguments) = (last + 1 - first, signature.inputs.len());
        if lines > MAX_LINES {
            self.found.push(format!("{file}:{first}: `{name}` has {lines} lines"));
        }
        if arguments > MAX_ARGUMENTS {
            self.found.push(format!("{file}:{first}: `{name}` has {arguments} arguments"));
        }
    }
}

impl<'ast> Visit<'ast> for Functions<'_> {
    without_tests! {
        visit_item: Item,
        visit_impl_item: syn::ImplItem,
        visit_trait_item: syn::TraitItem,
        visit_stmt: syn::Stmt,
    }

    fn visit_item_fn(&mut self, item: &'ast syn::ItemFn) {
        self.check(&item.sig, Some(&item.block));
        visit::visit_item_fn(self, item);
    }

    fn visit_impl_item_fn(&mut self, item: &'ast syn::ImplItemFn) {
        self.check(&item.sig, Some(&item.block));
        visit::visit_impl_item_fn(self, item);
    }

    fn visit_trait_item_fn(&mut self, item: &'ast syn::TraitItemFn) {
        self.check(&item.sig, item.default.as_ref());
        visit::visit_trait_item_fn(self, item);
    }
}

fn large_functions(sources: &Sources) -> Vec<String> {
    let large = |source: &Source| {
        let mut functions = Functions { file: &source.name, found: Vec::new() };
        functions.visit_file(&source.syntax);
        functions.found
    };
    sources.files.values().flat_map(large).collect()
}

#[test]
fn functions_fit_a_screen() {
    let found = large_functions(&Sources::read());
    assert!(
        found.is_empty(),
        "functions have at most {MAX_LINES} lines and {MAX_ARGUMENTS} arguments, but:\n{}",
        found.join("\n"),
    );
}

// ---------------------------------------------------------------- the checks, checked themselves

fn made_up<const K: usize>(files: [(&str, &str); K]) -> Sources {
    Sources::new(files.map(|(name, text)| (name.to_owned(), text.to_owned())))
}

/// The circles of a tree, each in one string, `src/` and `.rs` left out.
fn circles_of<const K: usize>(files: [(&str, &str); K]) -> Vec<String> {
    let short = |name: &String| name.replace("src/", "").replace(".rs", "");
    let join = |circle: &Vec<String>| circle.iter().map(short).collect::<Vec<_>>().join(" ");
    circles(&arrows(&made_up(files))).iter().map(join).collect()
}

/// A circle is found wherever the second of two siblings imports the first, whatever the form.
#[test]
fn circles_between_siblings_are_found() {
    for import in [
        "use crate::a::A;",
        "pub use crate::a::A as B;",
        "pub(crate) use super::a::A;",
        "use super::{c::C, a::{self, A}};",
        "use crate::{a, c::C};",
        "use crate::a::*;",
        "use super::a as other;",
        "fn f() { use crate::a::A; }",
        "fn f() -> crate::a::A { todo!() }",
        "fn f() { super::a::f(); }",
        "fn f(x: Vec<Option<super::a::A>>) {}",
        "impl crate::a::Trait for u8 {}",
        "impl<T: crate::a::Trait> Own for T {}",
        "fn f() { assert_eq!(1, g(crate::a::ONE)); }",
        "fn f() { crate::a::make!(); }",
        "mod inner { use super::super::a::A; }",
        "mod inner { pub(super) fn f() { crate::a::f() } }",
        "use self::super::a::A;",
    ] {
        let files = [
            ("lib.rs", "mod a; mod b; mod c; pub use a::A; pub use b::B;"),
            ("a.rs", "use crate::b::B; pub struct A;"),
            ("b.rs", import),
            ("c.rs", "use crate::a::A; pub struct C;"),
        ];
        let found = circles_of(files);
        let wanted = if import.contains("c::C") { vec!["a b c"] } else { vec!["a b"] };
        assert_eq!(found, wanted, "{import}");
    }
}

#[test]
fn circles_of_parents_and_children_are_found() {
    let lib = ("lib.rs", "pub mod a; pub use a::b::B;");
    let child = ("a/b.rs", "use super::A; pub struct B;");
    for import in [
        "use self::b::B;",
        "pub use b::B;",
        "pub use self::b::*;",
        "fn f() { b::f() }",
        "fn f() -> Vec<self::b::B> { vec![] }",
        "use crate::a::b; fn f() { b::f() }",
    ] {
        let parent = format!("mod b; pub struct A; {import}");
        assert_eq!(circles_of([lib, ("a.rs", &parent), child]), ["a a/b"], "{import}");
        assert_eq!(circles_of([lib, ("a/mod.rs", &parent), child]), ["a/b a/mod"], "{import}");
    }
    // A child may be declared by a parent that it imports.
    assert_eq!(circles_of([lib, ("a.rs", "mod b; pub struct A;"), child]), [""; 0]);
}

/// Names that `use` brings into a file are followed, modules above all.
#[test]
fn circles_by_names_of_modules_are_found() {
    let files = [
        ("lib.rs", "mod a; mod b; mod top;"),
        ("a.rs", "use crate::b::B; pub struct A;"),
        ("b.rs", "fn f() { t::c::f() } use crate::top as t; pub struct B;"),
        ("top.rs", "mod c;"),
        ("top/c.rs", "use crate::a; pub(super) fn f() { a::f() }"),
    ];
    assert_eq!(circles_of(files), ["a b top/c"]);
}

#[test]
fn imports_of_the_root_are_circles() {
    let lib = ("lib.rs", "mod a; mod b; pub use a::A; pub use b::B;");
    let b = ("b.rs", "use crate::a::A; pub struct B;");
    for import in ["use crate::B;", "use super::B;", "fn f() -> crate::B {}", "use crate::*;"] {
        assert_eq!(circles_of([lib, ("a.rs", import), b]), ["a lib"], "{import}");
    }
}

#[test]
fn circles_are_found_apart() {
    let files = [
        ("lib.rs", "mod a; mod b; mod c; mod d; mod e;"),
        ("a.rs", "use crate::b::B;"),
        ("b.rs", "use crate::a::A; use crate::c::C;"),
        ("c.rs", "use crate::d::D;"),
        ("d.rs", "use crate::e::E;"),
        ("e.rs", "\n\nuse crate::{\n    c::C,\n};"),
    ];
    assert_eq!(circles_of(files), ["a b", "c d e"]);
    let arrows = arrows(&made_up(files));
    let words = describe(&arrows, &circles(&arrows));
    for line in [
        "A circle of 2 files:\n  src/a.rs:1 imports src/b.rs: crate::b::B\n",
        "  the shortest: src/c.rs -> src/d.rs -> src/e.rs -> src/c.rs\n",
        "  src/e.rs:4 imports src/c.rs: crate::c::C\n",
    ] {
        assert!(words.contains(line), "{words}");
    }
}

/// Nothing is found where there is nothing.
#[test]
fn trees_without_circles_pass() {
    let files = [
        ("lib.rs", "//! See [`crate::a`].\npub mod a; mod b; mod t; pub use a::A;"),
        ("a.rs", "mod low; mod high; pub use high::High; pub struct A;"),
        // What both of them need is in the lower one, and the parent is not asked.
        ("a/low.rs", "/// [`super::high::High`]\npub(crate) struct Low;"),
        ("a/high.rs", "use super::low::Low; pub struct High(Low, std::ops::Range<u8>);"),
        (
            "b.rs",
            "use crate::a::A; use ::a::b; use t::T;
            /// [`crate::B`]
            pub(crate) fn f<T: Own>(x: T::Item) { Self::a::f(); x.a(); ::b::f() }
            pub(in crate::a) struct B;
            macro_rules! m { () => { $crate::A; crate::b::f() } }
            #[cfg(test)] mod tests { use super::*; use crate::B; }
            impl B { #[cfg(test)] fn f() { crate::f() } }
            fn g() { #[cfg(test)] crate::f(); #[cfg(all(test, unix))] let x = crate::F; }",
        ),
        ("t.rs", "#[cfg(test)] mod tests;"),
        ("t/tests.rs", "use crate::A;"),
    ];
    assert_eq!(circles_of(files), [""; 0]);
}

#[test]
fn code_for_tests_is_told_from_other_code() {
    let is_for_tests = |code: &str| {
        is_for_tests(&syn::parse_str::<Item>(&format!("{code} fn f() {{}}")).expect("an item"))
    };
    for code in ["#[cfg(test)]", "#[a] #[cfg(all(unix, test))]", "#[cfg(any(test))]", "#[test]"] {
        assert!(is_for_tests(code), "{code}");
    }
    for code in ["", "#[cfg(not(test))]", "#[cfg(any(test, unix))]", "#[cfg(feature = \"test\")]"] {
        assert!(!is_for_tests(code), "{code}");
    }
}

#[test]
fn gaps_in_a_tour_are_found() {
    let gaps = |docs: &str| {
        let lib = format!("{docs}\nmod low;\npub mod high;\nmod top;\n#[cfg(test)] mod tests;");
        gaps_in_tour(&made_up([
            ("lib.rs", &lib),
            ("low.rs", ""),
            ("high.rs", ""),
            ("high/one.rs", ""),
            ("high/two.rs", ""),
            ("top.rs", ""),
            ("top/one.rs", ""),
        ]))
    };
    let whole =
        "//! `low`, then [`high`] with\n//! `high::one` and [two](high), `top`, `top/one.rs`";
    assert_eq!(gaps(whole), [""; 0]);
    // Two modules are called `one`.
    let wanted = ["`high::one` is not named", "`top::one` is not named"];
    assert_eq!(gaps("//! `low` `high` `one` `two` `top`"), wanted);
    let wanted = ["`high` is not named after `low`, as it is declared"];
    assert_eq!(gaps("//! [high] `low` `high::one` `two` `top` `top::one`"), wanted);
    let code = "//! ```\n//! `low`\n//! ```\n//! `high` `high::one` `two` `top` `top::one` low";
    assert_eq!(gaps(code), ["`low` is not named"]);
}

#[test]
fn large_functions_are_found() {
    let function = |name: &str, lines: usize| {
        format!("/// Words.\nfn {name}() {{\n{}}}\n", "    f();\n".repeat(lines - 2))
    };
    let text = [
        function("fits", MAX_LINES),
        function("long", MAX_LINES + 1),
        "fn many(a: u8, b: u8, c: u8, d: u8, e: u8, f: u8, g: u8, h: u8) {}\n".to_owned(),
        "trait T { fn m(&self, b: u8, c: u8, d: u8, e: u8, f: u8, g: u8, h: u8); }\n".to_owned(),
        "fn all(a: u8, b: u8, c: u8, d: u8, e: u8, f: u8, g: u8) {}\n".to_owned(),
        format!("#[cfg(test)]\nmod tests {{\n{}}}", function("test", 2 * MAX_LINES)),
    ];
    let wanted = [
        "src/lib.rs:63: `long` has 61 lines",
        "src/lib.rs:124: `many` has 8 arguments",
        "src/lib.rs:125: `m` has 8 arguments",
    ];
    assert_eq!(large_functions(&made_up([("lib.rs", &text.concat())])), wanted);
}
