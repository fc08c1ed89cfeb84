//! The public API as a list, `tests/data/api.txt`, so that a change of it is seen where changes are
//! read.
//!
//! The list is made from the sources, without a compiler. It has a line for each thing that a user
//! of the crate can name, with the shortest of its paths; the other paths have lines with `use`.
//! Types from elsewhere have the paths by which they are imported. What a feature brings has the
//! feature's name in brackets at the end of its line. `{ .. }` stands for private fields after a
//! struct, and for a default after a member of a trait.
//!
//! Derived implementations of traits look like those written by hand. What a macro of the crate
//! makes is listed as the call of the macro, with the implementations as they stand in the macro.
//! What is marked `#[doc(hidden)]` is left out.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::fs;
use std::path::{Path, PathBuf};

use proc_macro2::{Delimiter, Spacing, TokenStream, TokenTree};
use quote::ToTokens;
use syn::punctuated::Punctuated;
use syn::visit::{self, Visit};
use syn::visit_mut::{self, VisitMut};
use syn::{
    Attribute, Fields, FnArg, GenericParam, Generics, ImplItem, Item, ItemImpl, Meta, Pat, Token,
    TraitItem, Type, UseTree, Visibility, WherePredicate, parse_quote,
};

/// The directory that has `src` and `tests` in it.
const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/..");

const CRATE: &str = "polyscan";

const HEADER: &str = "\
# The public API, an item a line. The test in api.rs compares it with the sources;
# with UPDATE_API=1 in its environment it writes them here.
";

// ---------------------------------------------------------------------------------- the sources

/// A module, or a thing in a module, as the names on the way to it from the crate's root.
type Names = Vec<String>;

/// Conditions of `cfg` under which something is there, in words.
type Conditions = BTreeSet<String>;

/// The modules of a crate with what is in them.
#[derive(Default)]
struct Sources {
    modules: BTreeMap<Names, Scope>,
}

#[derive(Default)]
struct Scope {
    /// What is there in other builds than those of tests.
    items: Vec<Item>,
    conditions: Conditions,
    names: HashMap<String, Name>,
    /// The paths that end in `*`.
    globs: Vec<Names>,
}

/// What a name in a module stands for.
enum Name {
    Module,
    Item,
    /// A path that `use` gives the name to.
    Import(Names),
}

/// What a path leads to.
#[derive(Debug, PartialEq)]
enum Found {
    Module(Names),
    /// An item, and what of it is named, such as a variant.
    Item(Names, Names),
    /// Something of another crate.
    Other(Names),
}

impl Sources {
    /// A crate whose files have the texts that `read` returns for their names.
    fn new(read: &dyn Fn(&str) -> Option<String>) -> Self {
        let mut sources = Self::default();
        let text = read("lib.rs").expect("a lib.rs");
        let items = syn::parse_file(&text).unwrap_or_else(|e| panic!("lib.rs: {e}")).items;
        sources.add(Names::new(), items, Conditions::new(), read);
        sources
    }

    fn add(
        &mut self,
        module: Names,
        items: Vec<Item>,
        conditions: Conditions,
        read: &dyn Fn(&str) -> Option<String>,
    ) {
        let mut scope = Scope { conditions, ..Scope::default() };
        for item in items {
            let attributes = attributes(&item);
            let Some(own) = conditions_of(attributes) else { continue };
            match &item {
                Item::Mod(child) => {
                    let name = child.ident.to_string();
                    let path = within(&module, [name.clone()]);
                    let items = match &child.content {
                        Some((_, items)) => items.clone(),
                        None => file_of(&path, read).items,
                    };
                    self.add(path, items, union(&scope.conditions, &own), read);
                    scope.names.insert(name, Name::Module);
                }
                Item::Use(item) => {
                    for (name, path) in imports(item) {
                        match name {
                            Some(name) => {
                                scope.names.entry(name).or_insert(Name::Import(path));
                            }
                            None => scope.globs.push(path),
                        }
                    }
                }
                other => {
                    // A module keeps its name where a function has the same.
                    if let Some(name) = name_of(other) {
                        scope.names.entry(name).or_insert(Name::Item);
                    }
                }
            }
            scope.items.push(item);
        }
        self.modules.insert(module, scope);
    }

    /// What a path leads to that stands in a module; `None` for names that no `use` brings and no
    /// item has, such as those that are everywhere.
    fn resolve(&self, module: &[String], path: &[String]) -> Option<Found> {
        let (first, rest) = path.split_first()?;
        match first.as_str() {
            "crate" => self.resolve_in(&[], rest),
            "self" => self.resolve_in(module, rest),
            "super" => {
                let (mut module, mut rest) = (module.split_last()?.1, rest);
                while let Some((first, others)) = rest.split_first()
                    && first == "super"
                {
                    (module, rest) = (module.split_last()?.1, others);
                }
                self.resolve_in(module, rest)
            }
            "" => Some(Found::Other(rest.to_vec())),
            _ => self
                .resolve_in(module, path)
                .or_else(|| (path.len() > 1).then(|| Found::Other(path.to_vec()))),
        }
    }

    /// What a path leads to that begins with a name in the module.
    fn resolve_in(&self, module: &[String], path: &[String]) -> Option<Found> {
        let Some((first, rest)) = path.split_first() else {
            return Some(Found::Module(module.to_vec()));
        };
        let scope = self.modules.get(module)?;
        match scope.names.get(first) {
            Some(Name::Module) => self.resolve_in(&within(module, [first.clone()]), rest),
            Some(Name::Item) => Some(Found::Item(within(module, [first.clone()]), rest.to_vec())),
            // `use image;`
            Some(Name::Import(path)) if path[0] == *first => {
                Some(Found::Other(within(path, rest.iter().cloned())))
            }
            Some(Name::Import(path)) => match self.resolve(module, path)? {
                Found::Module(module) => self.resolve_in(&module, rest),
                Found::Item(item, more) => {
                    Some(Found::Item(item, within(&more, rest.iter().cloned())))
                }
                Found::Other(path) => Some(Found::Other(within(&path, rest.iter().cloned()))),
            },
            None => scope.globs.iter().find_map(|glob| {
                // Another glob is not asked where this one leads to, nor is another crate.
                let is_own = ["crate", "self", "super"].contains(&glob[0].as_str())
                    || scope.names.contains_key(&glob[0]);
                let Some(Found::Module(other)) = is_own.then(|| self.resolve(module, glob))? else {
                    return None;
                };
                let has_name = self.modules.get(&other)?.names.contains_key(first);
                if has_name { self.resolve_in(&other, path) } else { None }
            }),
        }
    }
}

/// The file of a module.
fn file_of(module: &[String], read: &dyn Fn(&str) -> Option<String>) -> syn::File {
    let path = module.join("/");
    let names = [format!("{path}.rs"), format!("{path}/mod.rs")];
    let text = names.iter().find_map(|name| read(name));
    let text = text.unwrap_or_else(|| panic!("there is no {}", names.join(" and no ")));
    syn::parse_file(&text).unwrap_or_else(|e| panic!("{path}: {e}"))
}

fn within(names: &[String], more: impl IntoIterator<Item = String>) -> Names {
    names.iter().cloned().chain(more).collect()
}

fn union(first: &Conditions, second: &Conditions) -> Conditions {
    first | second
}

/// The names that an item brings, `None` for a glob, and the paths that they stand for.
fn imports(item: &syn::ItemUse) -> Vec<(Option<String>, Names)> {
    fn add(path: &Names, tree: &UseTree, found: &mut Vec<(Option<String>, Names)>) {
        let (name, new_name) = match tree {
            UseTree::Path(part) => {
                return add(&within(path, [part.ident.to_string()]), &part.tree, found);
            }
            UseTree::Group(group) => {
                return group.items.iter().for_each(|tree| add(path, tree, found));
            }
            UseTree::Glob(_) => return found.push((None, path.clone())),
            UseTree::Name(name) => (name.ident.to_string(), name.ident.to_string()),
            UseTree::Rename(name) => (name.ident.to_string(), name.rename.to_string()),
        };
        let is_self = name == "self" && !path.is_empty();
        let new_name =
            if is_self && new_name == "self" { path[path.len() - 1].clone() } else { new_name };
        let path = if is_self { path.clone() } else { within(path, [name]) };
        found.push((Some(new_name), path));
    }
    let start = if item.leading_colon.is_some() { vec![String::new()] } else { Names::new() };
    let mut found = Vec::new();
    add(&start, &item.tree, &mut found);
    found
}

fn attributes(item: &Item) -> &[Attribute] {
    match item {
        Item::Const(item) => &item.attrs,
        Item::Enum(item) => &item.attrs,
        Item::Fn(item) => &item.attrs,
        Item::Impl(item) => &item.attrs,
        Item::Macro(item) => &item.attrs,
        Item::Mod(item) => &item.attrs,
        Item::Static(item) => &item.attrs,
        Item::Struct(item) => &item.attrs,
        Item::Trait(item) => &item.attrs,
        Item::Type(item) => &item.attrs,
        Item::Union(item) => &item.attrs,
        Item::Use(item) => &item.attrs,
        other => panic!("the list knows nothing of `{}`", pretty(other.to_token_stream())),
    }
}

/// The name of an item that is named by a path. Macros have a name of their own, with `!`.
fn name_of(item: &Item) -> Option<String> {
    Some(match item {
        Item::Const(item) => item.ident.to_string(),
        Item::Enum(item) => item.ident.to_string(),
        Item::Fn(item) => item.sig.ident.to_string(),
        Item::Static(item) => item.ident.to_string(),
        Item::Struct(item) => item.ident.to_string(),
        Item::Trait(item) => item.ident.to_string(),
        Item::Type(item) => item.ident.to_string(),
        Item::Union(item) => item.ident.to_string(),
        Item::Macro(item) => format!("{}!", item.ident.as_ref()?),
        _ => return None,
    })
}

fn visibility(item: &Item) -> &Visibility {
    match item {
        Item::Const(item) => &item.vis,
        Item::Enum(item) => &item.vis,
        Item::Fn(item) => &item.vis,
        Item::Mod(item) => &item.vis,
        Item::Static(item) => &item.vis,
        Item::Struct(item) => &item.vis,
        Item::Trait(item) => &item.vis,
        Item::Type(item) => &item.vis,
        Item::Union(item) => &item.vis,
        Item::Use(item) => &item.vis,
        _ => &Visibility::Inherited,
    }
}

fn is_public(visibility: &Visibility) -> bool {
    matches!(visibility, Visibility::Public(_))
}

fn is_hidden(attributes: &[Attribute]) -> bool {
    attributes.iter().any(|attribute| {
        attribute.path().is_ident("doc")
            && attribute.parse_args::<syn::Ident>().is_ok_and(|word| word == "hidden")
    })
}

/// The conditions under which something is compiled; `None` if that is in tests alone.
fn conditions_of(attributes: &[Attribute]) -> Option<Conditions> {
    let mut conditions = Conditions::new();
    for attribute in attributes {
        if attribute.path().is_ident("cfg") {
            let condition: Meta = attribute.parse_args().expect("a condition");
            conditions.extend(parts_of(&condition).iter().map(condition_in_words));
        }
    }
    let is_for_tests = ["test", "doctest"].iter().any(|word| conditions.contains(*word));
    (!is_for_tests).then_some(conditions)
}

/// The conditions that must hold all.
fn parts_of(condition: &Meta) -> Vec<Meta> {
    match condition {
        Meta::List(list) if list.path.is_ident("all") => list_of(list),
        other => vec![other.clone()],
    }
}

fn list_of(list: &syn::MetaList) -> Vec<Meta> {
    let parse = Punctuated::<Meta, Token![,]>::parse_terminated;
    list.parse_args_with(parse).expect("a list").into_iter().collect()
}

/// A feature as its name, `not(x)` as `not x`, other conditions as they are.
fn condition_in_words(condition: &Meta) -> String {
    match condition {
        Meta::NameValue(pair) if pair.path.is_ident("feature") => {
            pretty(pair.value.to_token_stream()).replace('"', "")
        }
        Meta::List(list) if list.path.is_ident("not") => {
            format!("not {}", list_of(list).iter().map(condition_in_words).collect::<String>())
        }
        Meta::List(list) if list.path.is_ident("any") || list.path.is_ident("all") => {
            let parts: Vec<_> = list_of(list).iter().map(condition_in_words).collect();
            format!("{}({})", pretty(list.path.to_token_stream()), parts.join(", "))
        }
        other => pretty(other.to_token_stream()),
    }
}

// ------------------------------------------------------------------------------- the public names

/// The paths by which the items of a crate can be named from outside, the shortest first.
struct Public<'s> {
    sources: &'s Sources,
    paths: BTreeMap<Names, Vec<(Names, Conditions)>>,
    /// The modules that are public, and their paths.
    modules: BTreeSet<(Names, Names)>,
}

/// A line of the list, in the order of the list.
#[derive(PartialEq, Eq, PartialOrd, Ord)]
struct Line {
    /// The path of what it is about, or of the type or trait that that belongs to.
    owner: Names,
    kind: Kind,
    /// The name of a member.
    name: String,
    text: String,
}

#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Kind {
    Item,
    /// A field or a variant.
    Part,
    /// A function, a constant or a type that belongs to the item.
    Member,
    Impl,
}

#[derive(Default)]
struct Lines(Vec<Line>);

impl Lines {
    fn item(&mut self, path: &Names, text: String, conditions: &Conditions) {
        self.push(path, (Kind::Item, String::new()), text, conditions);
    }

    fn implementation(&mut self, owner: &Names, text: String, conditions: &Conditions) {
        self.push(owner, (Kind::Impl, String::new()), text, conditions);
    }

    /// Members of an item. Those with attributes that hide them are left out.
    fn members(&mut self, owner: &Names, members: Vec<Member<'_>>, conditions: &Conditions) {
        for Member { kind, name, text, attributes } in members {
            if let Some(own) = conditions_of(attributes)
                && !is_hidden(attributes)
            {
                let text = marks(attributes) + &text;
                self.push(owner, (kind, name), text, &union(conditions, &own));
            }
        }
    }

    fn push(
        &mut self,
        owner: &Names,
        (kind, name): (Kind, String),
        text: String,
        conditions: &Conditions,
    ) {
        let conditions: String = conditions.iter().map(|words| format!(" [{words}]")).collect();
        self.0.push(Line { owner: owner.clone(), kind, name, text: text + &conditions });
    }
}

/// A member of an item, to be listed.
struct Member<'a> {
    kind: Kind,
    name: String,
    text: String,
    attributes: &'a [Attribute],
}

impl<'s> Public<'s> {
    /// The public paths of a crate. Those that are lines by themselves are listed.
    fn new(sources: &'s Sources, lines: &mut Lines) -> Self {
        let mut public = Self { sources, paths: BTreeMap::new(), modules: BTreeSet::new() };
        let root = vec![CRATE.to_owned()];
        public.publish(&Names::new(), &root, &Conditions::new(), lines);
        for (module, scope) in &sources.modules {
            for item in &scope.items {
                let is_exported = |a: &Attribute| a.path().is_ident("macro_export");
                let attributes = attributes(item);
                if attributes.iter().any(is_exported)
                    && !is_hidden(attributes)
                    && let Some(name) = name_of(item)
                {
                    let path = within(&root, [name.clone()]);
                    let paths = public.paths.entry(within(module, [name])).or_default();
                    paths.push((path, Conditions::new()));
                }
            }
        }
        for paths in public.paths.values_mut() {
            paths.sort_by_key(|(path, _)| (path.len(), path.clone()));
            paths.dedup_by_key(|(path, _)| path.clone());
        }
        public
    }

    /// Collects what a module makes public that itself is public under a path.
    fn publish(
        &mut self,
        module: &Names,
        path: &Names,
        conditions: &Conditions,
        lines: &mut Lines,
    ) {
        if !self.modules.insert((module.clone(), path.clone())) {
            return;
        }
        let Some(scope) = self.sources.modules.get(module) else { return };
        for item in &scope.items {
            let attributes = attributes(item);
            if !is_public(visibility(item)) || is_hidden(attributes) {
                continue;
            }
            let own = conditions_of(attributes).expect("those for tests are left out");
            let conditions = union(conditions, &own);
            match item {
                Item::Mod(child) => {
                    let name = [child.ident.to_string()];
                    let found = Found::Module(within(module, name.clone()));
                    self.publish_as(&within(path, name), found, &conditions, lines);
                }
                Item::Use(item) => {
                    for (name, target) in imports(item) {
                        let found = self.sources.resolve(module, &target);
                        if let (None, Some(Found::Module(module))) = (&name, &found) {
                            self.publish(module, path, &conditions, lines);
                        } else {
                            let path = within(path, [name.unwrap_or_else(|| "*".to_owned())]);
                            let found = found.unwrap_or(Found::Other(target));
                            self.publish_as(&path, found, &conditions, lines);
                        }
                    }
                }
                other => {
                    let name = [name_of(other).expect("a public item has a name")];
                    let found = Found::Item(within(module, name.clone()), Names::new());
                    self.publish_as(&within(path, name), found, &conditions, lines);
                }
            }
        }
    }

    /// Collects a public path, and what is behind it.
    fn publish_as(
        &mut self,
        path: &Names,
        found: Found,
        conditions: &Conditions,
        lines: &mut Lines,
    ) {
        match found {
            Found::Module(module) => {
                lines.item(path, format!("pub mod {}", path.join("::")), conditions);
                self.publish(&module, path, conditions, lines);
            }
            Found::Item(item, rest) if rest.is_empty() => {
                self.paths.entry(item).or_default().push((path.clone(), conditions.clone()));
            }
            Found::Item(target, rest) => {
                let target = within(&target, rest).join("::");
                let text = format!("pub use crate::{target} as {}", path.join("::"));
                lines.item(path, text, conditions);
            }
            Found::Other(target) => {
                let text = format!("pub use {} as {}", target.join("::"), path.join("::"));
                lines.item(path, text, conditions);
            }
        }
    }

    /// The shortest path of an item, if it has any.
    fn path_of(&self, item: &Names) -> Option<&Names> {
        self.paths.get(item).map(|paths| &paths[0].0)
    }
}

// --------------------------------------------------------------------------------------- the list

/// The list of a crate.
fn list(sources: &Sources) -> String {
    let mut lines = Lines::default();
    let public = Public::new(sources, &mut lines);
    for (module, scope) in &sources.modules {
        for item in &scope.items {
            let own = conditions_of(attributes(item)).expect("those for tests are left out");
            let conditions = union(&scope.conditions, &own);
            match item {
                Item::Impl(item) => public.list_impl(module, item, &conditions, &mut lines),
                Item::Macro(call) if call.ident.is_none() => {
                    public.list_call(module, call, &conditions, &mut lines);
                }
                item => public.list_paths(module, item, &conditions, &mut lines),
            }
        }
    }
    let mut lines = lines.0;
    lines.sort();
    lines.dedup();
    let lines: String = lines.iter().map(|line| format!("{}\n", line.text)).collect();
    format!("{HEADER}\n{lines}")
}

impl Public<'_> {
    /// An item under the first of its paths, and the other paths.
    fn list_paths(&self, module: &Names, item: &Item, conditions: &Conditions, lines: &mut Lines) {
        let Some(name) = name_of(item) else { return };
        let Some(paths) = self.paths.get(&within(module, [name])) else { return };
        let [(first, more), others @ ..] = &paths[..] else { return };
        let first_conditions = union(conditions, more);
        self.list_item(module, item, first, &first_conditions, lines);
        self.list_derives(module, item, first, &first_conditions, lines);
        for (path, more) in others {
            let text = format!("pub use {} as {}", first.join("::"), path.join("::"));
            lines.item(path, text, &union(conditions, more));
        }
    }

    fn list_item(
        &self,
        module: &Names,
        item: &Item,
        path: &Names,
        conditions: &Conditions,
        lines: &mut Lines,
    ) {
        let words = self.words(module);
        let mut text = marks(attributes(item));
        let name = path.join("::");
        match item {
            Item::Const(item) => {
                let (ty, value) = (words.ty(&item.ty), value_of(&item.expr));
                text += &format!("pub const {name}: {ty} = {value}");
            }
            Item::Static(item) => text += &format!("pub static {name}: {}", words.ty(&item.ty)),
            Item::Fn(item) => {
                text += &format!("pub {}", words.signature(&item.sig, &name, &Generics::default()));
            }
            Item::Type(item) => {
                let words = words.with(&item.generics);
                let (generics, ty) = (words.generics(&item.generics), words.ty(&item.ty));
                text += &format!("pub type {name}{generics} = {ty}");
            }
            Item::Macro(item) => {
                let rules: Vec<_> = rules_of(&item.mac).into_iter().map(|rule| rule.0).collect();
                text += &format!("macro {name} {{ {} }}", rules.join("; "));
            }
            Item::Struct(item) => {
                let words = words.with(&item.generics);
                text += &format!("pub struct {name}{}", words.generics(&item.generics));
                text += &words.struct_fields(&item.fields);
                text += &words.bounds(&item.generics);
                lines.members(path, words.fields(&name, &item.fields), conditions);
            }
            Item::Union(item) => {
                let words = words.with(&item.generics);
                text += &format!("pub union {name}{}", words.generics(&item.generics));
                text += &words.bounds(&item.generics);
                let fields = Fields::Named(item.fields.clone());
                lines.members(path, words.fields(&name, &fields), conditions);
            }
            Item::Enum(item) => {
                let words = words.with(&item.generics);
                text += &format!("pub enum {name}{}", words.generics(&item.generics));
                text += &words.bounds(&item.generics);
                let variants = item.variants.iter().map(|variant| words.variant(&name, variant));
                lines.members(path, variants.collect(), conditions);
            }
            Item::Trait(item) => {
                let words = words.with(&item.generics);
                let unsafety = item.unsafety.map_or("", |_| "unsafe ");
                text += &format!("pub {unsafety}trait {name}{}", words.generics(&item.generics));
                text += &words.supertraits(&item.supertraits);
                text += &words.bounds(&item.generics);
                let members =
                    item.items.iter().filter_map(|member| words.trait_member(&name, member));
                lines.members(path, members.collect(), conditions);
            }
            _ => unreachable!("other items have no names"),
        }
        lines.item(path, text, conditions);
    }

    /// The derived implementations of an item, as one would write them by hand.
    fn list_derives(
        &self,
        module: &Names,
        item: &Item,
        path: &Names,
        conditions: &Conditions,
        lines: &mut Lines,
    ) {
        let generics = match item {
            Item::Struct(item) => &item.generics,
            Item::Enum(item) => &item.generics,
            Item::Union(item) => &item.generics,
            _ => return,
        };
        let mut traits = Vec::new();
        for attribute in attributes(item).iter().filter(|a| a.path().is_ident("derive")) {
            let parse = Punctuated::<syn::Path, Token![,]>::parse_terminated;
            let derived = attribute.parse_args_with(parse).expect("a list of traits");
            traits.extend(derived.iter().flat_map(|derived| self.derived(module, derived, item)));
        }
        let words = self.words(module).with(generics);
        for derived in traits {
            let mut generics = generics.clone();
            for parameter in generics.type_params_mut() {
                parameter.bounds.push(parse_quote!(#derived));
                parameter.default = None;
            }
            let start = words.generics(&generics);
            let arguments = pretty(generics.split_for_impl().1.to_token_stream());
            let (name, bounds) = (path.join("::"), words.bounds(&generics));
            let text =
                format!("impl{start} {} for {name}{arguments}{bounds}", words.path(&derived));
            lines.implementation(path, text, conditions);
        }
    }

    /// The traits that a derive implements.
    fn derived(&self, module: &Names, derive: &syn::Path, item: &Item) -> Vec<syn::Path> {
        let names = names_of(derive);
        let found = self.sources.resolve(module, &names);
        if found == Some(Found::Other(vec!["thiserror".to_owned(), "Error".to_owned()])) {
            let mut sources = FromFields(Vec::new());
            sources.visit_item(item);
            let from = sources.0.into_iter().map(|ty| parse_quote!(From<#ty>));
            let error = [parse_quote!(std::error::Error), parse_quote!(std::fmt::Display)];
            return error.into_iter().chain(from).collect();
        }
        match names[names.len() - 1].as_str() {
            "Debug" => vec![parse_quote!(std::fmt::Debug)],
            "Hash" => vec![parse_quote!(std::hash::Hash)],
            _ => vec![derive.clone()],
        }
    }

    /// The public members of an implementation, or the fact that a trait is implemented.
    fn list_impl(
        &self,
        module: &Names,
        item: &ItemImpl,
        conditions: &Conditions,
        lines: &mut Lines,
    ) {
        let words = self.words(module).with(&item.generics);
        let mut used = Used { words: &words, public: Vec::new(), has_private: false };
        used.visit_type(&item.self_ty);
        if let Some((path, _)) = &item.trait_ {
            used.visit_path(path);
        }
        // What nobody can name, nobody can use.
        if used.public.is_empty() || used.has_private || is_hidden(&item.attrs) {
            return;
        }
        let public_path = |path| match words.resolve(path)? {
            Found::Item(item, _) => self.path_of(&item),
            _ => None,
        };
        let of_type = path_of_type(&item.self_ty).and_then(public_path);
        let of_trait = item.trait_.as_ref().and_then(|(path, _)| public_path(path));
        let owner = of_type.or(of_trait).unwrap_or(&used.public[0]);
        let ty = words.ty(&item.self_ty);
        if let Some((path, _)) = &item.trait_ {
            let unsafety = item.unsafety.map_or("", |_| "unsafe ");
            let (generics, bounds) = (words.generics(&item.generics), words.bounds(&item.generics));
            let (path, types) = (words.path(path), words.associated_types(&item.items));
            let text = format!("{unsafety}impl{generics} {path} for {ty}{bounds}{types}");
            lines.implementation(owner, text, conditions);
        } else {
            let members = item.items.iter();
            let members =
                members.filter_map(|member| words.inherent_member(&ty, &item.generics, member));
            lines.members(owner, members.collect(), conditions);
        }
    }

    /// The call of a macro that makes items.
    fn list_call(
        &self,
        module: &Names,
        call: &syn::ItemMacro,
        conditions: &Conditions,
        lines: &mut Lines,
    ) {
        let name = call.mac.path.to_token_stream().to_string();
        let definition = self.sources.modules.values().flat_map(|scope| &scope.items).find_map(
            |item| match item {
                Item::Macro(item) if item.ident.as_ref().is_some_and(|ident| *ident == name) => {
                    Some(&item.mac)
                }
                _ => None,
            },
        );
        let mut made = Vec::new();
        for (_, body) in definition.into_iter().flat_map(rules_of) {
            headers_of_impls(body, &mut made);
        }
        let made = if made.is_empty() { String::new() } else { format!(": {}", made.join("; ")) };
        let owner = within(&[CRATE.to_owned()], module.iter().cloned());
        let arguments = pretty(call.mac.tokens.clone());
        let text = format!("in {}, {name}!({arguments}){made}", owner.join("::"));
        lines.implementation(&owner, text, conditions);
    }

    /// The words for what stands in a module.
    fn words<'p>(&'p self, module: &'p Names) -> Words<'p> {
        Words { public: self, module, parameters: BTreeSet::from(["Self".to_owned()]) }
    }
}

/// The path of a type, or of what it refers to.
fn path_of_type(ty: &Type) -> Option<&syn::Path> {
    match ty {
        Type::Path(ty) => Some(&ty.path),
        Type::Reference(ty) => path_of_type(&ty.elem),
        _ => None,
    }
}

/// The types of fields that an error is made from.
struct FromFields(Vec<Type>);

impl Visit<'_> for FromFields {
    fn visit_field(&mut self, field: &syn::Field) {
        if field.attrs.iter().any(|attribute| attribute.path().is_ident("from")) {
            self.0.push(field.ty.clone());
        }
    }
}

/// The rules of a macro: what they match, and what they make of it.
fn rules_of(definition: &syn::Macro) -> Vec<(String, TokenStream)> {
    let groups = definition.tokens.clone().into_iter().filter_map(|token| match token {
        TokenTree::Group(group) => Some(group),
        _ => None,
    });
    let groups: Vec<_> = groups.collect();
    let rule = |pair: &[proc_macro2::Group]| (pretty(pair[0].to_token_stream()), pair[1].stream());
    groups.chunks_exact(2).map(rule).collect()
}

/// What stands from `impl` to the brace, wherever in some tokens.
fn headers_of_impls(tokens: TokenStream, found: &mut Vec<String>) {
    let mut header: Option<TokenStream> = None;
    for token in tokens {
        let is_impl = matches!(&token, TokenTree::Ident(word) if word == "impl");
        match token {
            TokenTree::Group(group) => {
                if group.delimiter() == Delimiter::Brace {
                    found.extend(header.take().map(pretty));
                } else if let Some(header) = &mut header {
                    header.extend([TokenTree::Group(group.clone())]);
                }
                headers_of_impls(group.stream(), found);
            }
            token if is_impl => header = Some(token.into()),
            token => {
                if let Some(header) = &mut header {
                    header.extend([token]);
                }
            }
        }
    }
}

/// The attributes that are listed.
fn marks(attributes: &[Attribute]) -> String {
    let listed = ["non_exhaustive", "must_use", "deprecated", "repr"];
    let is_listed = |a: &&Attribute| listed.iter().any(|name| a.path().is_ident(name));
    let marks = attributes.iter().filter(is_listed);
    marks.map(|mark| format!("{} ", pretty(mark.to_token_stream()))).collect()
}

/// The value of a constant, or the beginning of it.
fn value_of(value: &syn::Expr) -> String {
    let value = pretty(value.to_token_stream());
    if value.chars().count() <= 60 { value } else { "..".to_owned() }
}

fn names_of(path: &syn::Path) -> Names {
    let start = path.leading_colon.map(|_| String::new());
    start.into_iter().chain(path.segments.iter().map(|part| part.ident.to_string())).collect()
}

// -------------------------------------------------------------------------------- code as words

/// Code of a module, printed with the paths by which things can be named from outside.
#[derive(Clone)]
struct Words<'p> {
    public: &'p Public<'p>,
    module: &'p Names,
    /// The generic parameters, which no path begins with.
    parameters: BTreeSet<String>,
}

impl Words<'_> {
    /// The words for what has generic parameters.
    fn with(&self, generics: &Generics) -> Self {
        let mut words = self.clone();
        for parameter in &generics.params {
            match parameter {
                GenericParam::Type(parameter) => {
                    words.parameters.insert(parameter.ident.to_string())
                }
                GenericParam::Const(parameter) => {
                    words.parameters.insert(parameter.ident.to_string())
                }
                GenericParam::Lifetime(_) => false,
            };
        }
        words
    }

    fn ty(&self, ty: &Type) -> String {
        let mut ty = ty.clone();
        Qualify(self).visit_type_mut(&mut ty);
        pretty(ty.to_token_stream())
    }

    fn path(&self, path: &syn::Path) -> String {
        let mut path = path.clone();
        Qualify(self).visit_path_mut(&mut path);
        pretty(path.to_token_stream())
    }

    /// The parameters with their bounds.
    fn generics(&self, generics: &Generics) -> String {
        let mut generics = Generics { where_clause: None, ..generics.clone() };
        Qualify(self).visit_generics_mut(&mut generics);
        pretty(generics.to_token_stream())
    }

    /// The bounds that stand after `where`.
    fn bounds(&self, generics: &Generics) -> String {
        self.where_words(generics.where_clause.iter().flat_map(|clause| &clause.predicates))
    }

    fn where_words<'w>(&self, bounds: impl IntoIterator<Item = &'w WherePredicate>) -> String {
        let words = bounds.into_iter().map(|bound| {
            let mut bound = bound.clone();
            Qualify(self).visit_where_predicate_mut(&mut bound);
            pretty(bound.to_token_stream())
        });
        let words: Vec<_> = words.collect();
        if words.is_empty() { String::new() } else { format!(" where {}", words.join(", ")) }
    }

    fn supertraits(&self, bounds: &Punctuated<syn::TypeParamBound, Token![+]>) -> String {
        let words = bounds.iter().map(|bound| {
            let mut bound = bound.clone();
            Qualify(self).visit_type_param_bound_mut(&mut bound);
            pretty(bound.to_token_stream())
        });
        let words: Vec<_> = words.collect();
        if words.is_empty() { String::new() } else { format!(": {}", words.join(" + ")) }
    }

    /// A function by the name that it is given here. `outer` are the parameters of the
    /// implementation that it is in, whose bounds are added to its own.
    fn signature(&self, signature: &syn::Signature, name: &str, outer: &Generics) -> String {
        let words = self.with(&signature.generics);
        let mut signature = signature.clone();
        for input in &mut signature.inputs {
            match input {
                FnArg::Receiver(receiver) => receiver.mutability = None,
                FnArg::Typed(input) => {
                    // The name, if it has one.
                    *input.pat = match &*input.pat {
                        Pat::Ident(pattern) => {
                            let ident = &pattern.ident;
                            parse_quote!(#ident)
                        }
                        _ => parse_quote!(_),
                    };
                    input.attrs.clear();
                }
            }
        }
        Qualify(&words).visit_signature_mut(&mut signature);
        let own = signature.generics.where_clause.take();
        let mut start = Vec::new();
        start.extend(signature.constness.map(|_| "const "));
        start.extend(signature.asyncness.map(|_| "async "));
        if matches!(signature.safety, syn::Safety::Unsafe(_)) {
            start.push("unsafe ");
        }
        let abi = signature.abi.as_ref().map(|abi| pretty(abi.to_token_stream()) + " ");
        let generics = pretty(signature.generics.to_token_stream());
        let inputs = signature.inputs.iter().map(|input| pretty(input.to_token_stream()));
        let inputs: Vec<_> = inputs.collect();
        let output = pretty(signature.output.to_token_stream());
        let output = if output.is_empty() { output } else { format!(" {output}") };
        let of_parameters = outer.type_params().filter(|parameter| !parameter.bounds.is_empty());
        let of_parameters: Vec<WherePredicate> = of_parameters
            .map(|parameter| {
                let (ident, bounds) = (&parameter.ident, &parameter.bounds);
                parse_quote!(#ident: #bounds)
            })
            .collect();
        let after_where =
            outer.where_clause.iter().chain(&own).flat_map(|clause| &clause.predicates);
        let bounds = words.where_words(of_parameters.iter().chain(after_where));
        let (start, abi, inputs) = (start.concat(), abi.unwrap_or_default(), inputs.join(", "));
        format!("{start}{abi}fn {name}{generics}({inputs}){output}{bounds}")
    }

    /// What follows the name of a struct: the fields of a tuple, private ones as `_`, or whether
    /// there are private fields.
    fn struct_fields(&self, fields: &Fields) -> String {
        let is_seen = |field: &syn::Field| is_public(&field.vis) && !is_hidden(&field.attrs);
        match fields {
            Fields::Unnamed(fields) => {
                let words = fields.unnamed.iter().map(|field| {
                    if is_seen(field) {
                        format!("pub {}", self.ty(&field.ty))
                    } else {
                        "_".to_owned()
                    }
                });
                format!("({})", words.collect::<Vec<_>>().join(", "))
            }
            fields if fields.iter().all(is_seen) => String::new(),
            _ => " { .. }".to_owned(),
        }
    }

    /// The public fields that have names.
    fn fields<'a>(&self, owner: &str, fields: &'a Fields) -> Vec<Member<'a>> {
        let public = fields.iter().filter(|field| is_public(&field.vis));
        let member = |field: &'a syn::Field| {
            let name = field.ident.as_ref()?.to_string();
            let text = format!("pub {owner}::{name}: {}", self.ty(&field.ty));
            Some(Member { kind: Kind::Part, name, text, attributes: &field.attrs })
        };
        public.filter_map(member).collect()
    }

    fn variant<'a>(&self, owner: &str, variant: &'a syn::Variant) -> Member<'a> {
        let types = variant.fields.iter().map(|field| {
            let name = field.ident.as_ref().map_or(String::new(), |name| format!("{name}: "));
            name + &self.ty(&field.ty)
        });
        let types = types.collect::<Vec<_>>().join(", ");
        let fields = match &variant.fields {
            Fields::Named(_) => format!(" {{ {types} }}"),
            Fields::Unnamed(_) => format!("({types})"),
            Fields::Unit => String::new(),
        };
        let value = variant.discriminant.as_ref();
        let value = value.map_or(String::new(), |(_, value)| format!(" = {}", value_of(value)));
        let name = variant.ident.to_string();
        let text = format!("{owner}::{name}{fields}{value}");
        Member { kind: Kind::Part, name, text, attributes: &variant.attrs }
    }

    fn trait_member<'a>(&self, owner: &str, member: &'a TraitItem) -> Option<Member<'a>> {
        let (name, mut text, attributes, has_default) = match member {
            TraitItem::Fn(item) => {
                let name = item.sig.ident.to_string();
                let path = format!("{owner}::{name}");
                let text = self.signature(&item.sig, &path, &Generics::default());
                (name, text, &item.attrs, item.default.is_some())
            }
            TraitItem::Const(item) => {
                let name = item.ident.to_string();
                let text = format!("const {owner}::{name}: {}", self.ty(&item.ty));
                (name, text, &item.attrs, item.default.is_some())
            }
            TraitItem::Type(item) => {
                let name = item.ident.to_string();
                let words = self.with(&item.generics);
                let (generics, bounds) =
                    (words.generics(&item.generics), words.supertraits(&item.bounds));
                let text = format!("type {owner}::{name}{generics}{bounds}");
                (name, text, &item.attrs, item.default.is_some())
            }
            _ => return None,
        };
        if has_default {
            text += " { .. }";
        }
        Some(Member { kind: Kind::Member, name, text, attributes })
    }

    /// A public member of the type itself.
    fn inherent_member<'a>(
        &self,
        ty: &str,
        generics: &Generics,
        member: &'a ImplItem,
    ) -> Option<Member<'a>> {
        let (name, text, attributes) = match member {
            ImplItem::Fn(item) if is_public(&item.vis) => {
                let name = item.sig.ident.to_string();
                let signature = self.signature(&item.sig, &format!("{ty}::{name}"), generics);
                (name, format!("pub {signature}"), &item.attrs)
            }
            ImplItem::Const(item) if is_public(&item.vis) => {
                let (name, value) = (item.ident.to_string(), value_of(&item.expr));
                let text = format!("pub const {ty}::{name}: {} = {value}", self.ty(&item.ty));
                (name, text, &item.attrs)
            }
            _ => return None,
        };
        Some(Member { kind: Kind::Member, name, text, attributes })
    }

    fn associated_types(&self, members: &[ImplItem]) -> String {
        let types = members.iter().filter_map(|member| match member {
            ImplItem::Type(ty) => Some(format!("type {} = {}", ty.ident, self.ty(&ty.ty))),
            _ => None,
        });
        let types: Vec<_> = types.collect();
        if types.is_empty() { String::new() } else { format!(" {{ {} }}", types.join("; ")) }
    }

    /// What a path leads to, unless it begins with a generic parameter.
    fn resolve(&self, path: &syn::Path) -> Option<Found> {
        let names = names_of(path);
        let is_parameter = self.parameters.contains(&names[0]);
        if is_parameter { None } else { self.public.sources.resolve(self.module, &names) }
    }
}

/// Replaces paths by those that can be used from outside.
struct Qualify<'w, 'p>(&'w Words<'p>);

impl VisitMut for Qualify<'_, '_> {
    fn visit_path_mut(&mut self, path: &mut syn::Path) {
        visit_mut::visit_path_mut(self, path);
        let names = match self.0.resolve(path) {
            Some(Found::Item(item, rest)) => match self.0.public.path_of(&item) {
                Some(names) => within(names, rest),
                None => return,
            },
            Some(Found::Other(names)) => names,
            Some(Found::Module(_)) | None => return,
        };
        // Arguments stay where they are, counted from the end.
        let mut arguments = path.segments.iter().rev().map(|part| part.arguments.clone());
        let parts = names.iter().rev().map(|name| syn::PathSegment {
            ident: syn::Ident::new(name, proc_macro2::Span::call_site()),
            arguments: arguments.next().unwrap_or_default(),
        });
        let mut parts: Vec<_> = parts.collect();
        parts.reverse();
        *path = syn::Path { leading_colon: None, segments: parts.into_iter().collect() };
    }

    // The part in `<T as Trait>::Item` is a number of names, which must stay the same.
    fn visit_type_path_mut(&mut self, path: &mut syn::TypePath) {
        match &mut path.qself {
            Some(ty) => self.visit_type_mut(&mut ty.ty),
            None => self.visit_path_mut(&mut path.path),
        }
    }

    // Names of attributes are none of the crate's.
    fn visit_attribute_mut(&mut self, _: &mut Attribute) {}
}

/// Collects the paths of the crate's items that a piece of code names.
struct Used<'w, 'p> {
    words: &'w Words<'p>,
    /// The public paths of those that have one.
    public: Vec<Names>,
    /// Whether others are among them.
    has_private: bool,
}

impl Visit<'_> for Used<'_, '_> {
    fn visit_path(&mut self, path: &syn::Path) {
        if let Some(Found::Item(item, _)) = self.words.resolve(path) {
            match self.words.public.path_of(&item) {
                Some(path) => self.public.push(path.clone()),
                None => self.has_private = true,
            }
        }
        visit::visit_path(self, path);
    }
}

/// Tokens with spaces where one would write them in types and signatures.
fn pretty(tokens: TokenStream) -> String {
    let mut words = Vec::new();
    split(tokens, &mut words);
    let mut text = String::new();
    for (i, word) in words.iter().enumerate() {
        let before = if i > 1 { &words[i - 2] } else { "" };
        if i > 0 && is_apart(before, &words[i - 1], word) {
            text.push(' ');
        }
        text.push_str(word);
    }
    text
}

/// The words that tokens are: names, literals, brackets, and operators of up to three characters.
fn split(tokens: TokenStream, words: &mut Vec<String>) {
    const LONG: [&str; 13] =
        ["::", "->", "=>", "..", "...", "..=", "<<", ">>", "&&", "||", "==", "!=", "<="];
    let mut joint = String::new();
    for token in tokens {
        match token {
            TokenTree::Group(group) => {
                let (open, close) = match group.delimiter() {
                    Delimiter::Parenthesis => ("(", ")"),
                    Delimiter::Bracket => ("[", "]"),
                    Delimiter::Brace => ("{", "}"),
                    Delimiter::None => ("", ""),
                };
                words.extend((!open.is_empty()).then(|| open.to_owned()));
                split(group.stream(), words);
                words.extend((!close.is_empty()).then(|| close.to_owned()));
            }
            TokenTree::Punct(punct) => {
                let longer = format!("{joint}{}", punct.as_char());
                if joint.is_empty() || LONG.contains(&longer.as_str()) {
                    joint = longer;
                } else {
                    words.push(std::mem::replace(&mut joint, punct.as_char().to_string()));
                }
                if punct.spacing() == Spacing::Alone {
                    words.push(std::mem::take(&mut joint));
                }
            }
            // A lifetime is one word.
            TokenTree::Ident(ident) => words.push(std::mem::take(&mut joint) + &ident.to_string()),
            TokenTree::Literal(literal) => words.push(literal.to_string()),
        }
    }
    words.extend((!joint.is_empty()).then_some(joint));
}

/// Whether there is a space between two words.
fn is_apart(before: &str, word: &str, next: &str) -> bool {
    let is_name = |word: &str| word.starts_with(|c: char| c.is_alphanumeric() || c == '_');
    let is_keyword =
        |word| ["mut", "const", "dyn", "as", "in", "where", "impl", "for"].contains(&word);
    let is_operator =
        |word| ["", "=", "(", "[", ",", ":", "->", "<", "+", "-", "*"].contains(&word);
    match (word, next) {
        ("{", "}") => false,
        ("(" | "[" | "&" | "!" | "#" | "$" | "?" | "." | ".." | "..=" | "::" | "<", _) => false,
        // A sign, or a pointer.
        ("-" | "*", _) if is_operator(before) => false,
        (_, ")" | "]" | "," | ";" | ":" | "." | ".." | "..=" | "!" | ">") => false,
        (_, "?" | "::" | "<") => ["+", ":", "->", "=", ",", "as", "dyn"].contains(&word),
        (_, "(" | "[") => is_keyword(word) || !is_name(word) && word != ">" && word != ")",
        (")", "*") => false,
        _ => true,
    }
}

// --------------------------------------------------------------------------------------- the tests

fn path_of_list() -> PathBuf {
    Path::new(ROOT).join("tests/data/api.txt")
}

#[test]
fn the_public_api_is_as_listed() {
    let src = Path::new(ROOT).join("src");
    let now = list(&Sources::new(&|name| fs::read_to_string(src.join(name)).ok()));
    if std::env::var_os("UPDATE_API").is_some_and(|value| value == "1") {
        fs::write(path_of_list(), now).expect("tests/data/api.txt can be written");
        return;
    }
    let listed = fs::read_to_string(path_of_list()).unwrap_or_default();
    let differences = differences(&listed, &now);
    assert!(
        differences.is_empty(),
        "the public API is not as tests/data/api.txt lists it:\n\n{}\n\n\
         If that is meant, accept it by UPDATE_API=1 in the environment of this test, and tell of it \
         in CHANGELOG.md.",
        differences.join("\n"),
    );
}

/// A crate that has some of everything: its `lib.rs`, `inner.rs` and `outer/mod.rs`.
const MADE_UP: [&str; 3] = [
    r#"
//! Documentation.
mod inner;
pub mod outer;
mod macros { pair!(u8, [u8; 4]); }
#[cfg(feature = "extra")]
pub mod extra { pub fn on() {} #[cfg(unix)] pub fn unix() {} }
pub use inner::{Deep, deeper::*};
#[doc(inline)] pub use std::ops::Range as Interval;
#[doc(hidden)] pub fn hidden() {}
fn private() {}
#[cfg(test)] pub fn test() {}
#[must_use] #[inline] pub const fn area([w, h]: [u32; 2], mut by: &mut u32) -> u32 { 0 }
pub static WORDS: &[&'static str] = &[];
pub type Pair<T> = (T, inner::Deep<T>);
#[macro_export] macro_rules! make { ($a:expr) => { 1 }; (all) => { 2 }; }
macro_rules! pair { ($a:ty, $b:ty) => { impl crate::Deeper for $a {} impl $b {} } }
#[cfg(test)] mod tests { pub struct Test; impl crate::Deeper for Test {} }
"#,
    r#"
use std::fmt::{self, Debug};
use super::outer::Kind;
pub mod deeper {
    pub trait Deeper: Sized + super::Debug {
        const N: usize = 1;
        type Item: Clone;
        fn a(&self);
        fn b(self) -> Self::Item where Self: Copy { todo!() }
    }
}
#[derive(Clone, Debug)]
pub struct Deep<T: Copy, U = u8> { pub kind: Kind, pub(crate) inside: T, pub other: U }
impl<T: Copy, U> Deep<T, U> {
    pub const ZERO: i32 = -1;
    pub fn map<F>(mut self, f: F) -> Option<Kind> where F: FnOnce(T) -> (U, T) { None }
    #[cfg(all(feature = "extra", not(feature = "less")))] pub fn less(self: &Self) {}
    #[doc(hidden)] pub fn hidden() {}
    fn private() {}
}
impl<T: Copy> fmt::Display for Deep<T> {}
impl<'a, T: Copy> Iterator for &'a Deep<T> { type Item = &'a [T]; fn next() {} }
impl super::Deeper for Vec<Secret> {}
impl super::Deeper for [Kind; 2] { type Item = Box<Kind>; }
impl From<Kind> for String {}
pub struct Secret;
impl Secret { pub fn unseen() {} }
"#,
    r#"
pub use crate::inner::Deep as Renamed;
#[derive(Copy, thiserror::Error)]
#[non_exhaustive]
pub enum Kind { Unit = 3, #[cfg(feature = "extra")] Tuple(#[from] std::io::Error), Named { a: u8 } }
pub struct Tuple(pub u8, u16);
pub fn f(g: &dyn Fn(&[Kind; LEN]) -> Tuple, h: &(impl Into<Kind> + ?Sized)) -> Result<(), Kind> {}
pub const LEN: usize = 1 << 3;
"#,
];

/// Its list.
const MADE_UP_LIST: &str = "\
pub struct polyscan::Deep<T: Copy, U = u8> { .. }
pub polyscan::Deep::kind: polyscan::outer::Kind
pub polyscan::Deep::other: U
pub const polyscan::Deep<T, U>::ZERO: i32 = -1
pub fn polyscan::Deep<T, U>::less(self: &Self) where T: Copy [extra] [not less]
pub fn polyscan::Deep<T, U>::map<F>(self, f: F) -> Option<polyscan::outer::Kind> where T: Copy, F: FnOnce(T) -> (U, T)
impl<'a, T: Copy> Iterator for &'a polyscan::Deep<T> { type Item = &'a [T] }
impl<T: Copy + Clone, U: Clone> Clone for polyscan::Deep<T, U>
impl<T: Copy + std::fmt::Debug, U: std::fmt::Debug> std::fmt::Debug for polyscan::Deep<T, U>
impl<T: Copy> std::fmt::Display for polyscan::Deep<T>
pub trait polyscan::Deeper: Sized + std::fmt::Debug
type polyscan::Deeper::Item: Clone
const polyscan::Deeper::N: usize { .. }
fn polyscan::Deeper::a(&self)
fn polyscan::Deeper::b(self) -> Self::Item where Self: Copy { .. }
impl polyscan::Deeper for [polyscan::outer::Kind; 2] { type Item = Box<polyscan::outer::Kind> }
pub use std::ops::Range as polyscan::Interval
pub type polyscan::Pair<T> = (T, polyscan::Deep<T>)
pub static polyscan::WORDS: &[&'static str]
#[must_use] pub const fn polyscan::area(_: [u32; 2], by: &mut u32) -> u32
pub mod polyscan::extra [extra]
pub fn polyscan::extra::on() [extra]
pub fn polyscan::extra::unix() [extra] [unix]
in polyscan::macros, pair!(u8, [u8; 4]): impl crate::Deeper for $a; impl $b
macro polyscan::make! { ($a: expr); (all) }
pub mod polyscan::outer
#[non_exhaustive] pub enum polyscan::outer::Kind
polyscan::outer::Kind::Named { a: u8 }
polyscan::outer::Kind::Tuple(std::io::Error) [extra]
polyscan::outer::Kind::Unit = 3
impl Copy for polyscan::outer::Kind
impl From<polyscan::outer::Kind> for String
impl From<std::io::Error> for polyscan::outer::Kind
impl std::error::Error for polyscan::outer::Kind
impl std::fmt::Display for polyscan::outer::Kind
pub const polyscan::outer::LEN: usize = 1 << 3
pub use polyscan::Deep as polyscan::outer::Renamed
pub struct polyscan::outer::Tuple(pub u8, _)
pub fn polyscan::outer::f(g: &dyn Fn(&[polyscan::outer::Kind; polyscan::outer::LEN]) -> polyscan::outer::Tuple, h: &(impl Into<polyscan::outer::Kind> + ?Sized)) -> Result<(), polyscan::outer::Kind>
";

#[test]
fn a_list_has_it_all() {
    let read = |name: &str| {
        let file = ["lib.rs", "inner.rs", "outer/mod.rs"].iter().position(|file| *file == name)?;
        Some(MADE_UP[file].to_owned())
    };
    let found = list(&Sources::new(&read));
    let found = found.strip_prefix(HEADER).expect("the header").trim_start();
    assert_eq!(found, MADE_UP_LIST, "{}", differences(MADE_UP_LIST, found).join("\n"));
}

#[test]
fn differences_are_told_by_line() {
    assert_eq!(differences("a\nb\nd\n", "a\r\nb\r\nd\r\n"), [""; 0]);
    assert_eq!(differences("a\nb\nd\n", "a\nc\nd\ne\n"), ["- b", "+ c", "+ e"]);
}

/// The lines that are in one list alone, with `-` those that are gone and with `+` those that came.
fn differences(listed: &str, now: &str) -> Vec<String> {
    let (old, new): (BTreeSet<_>, BTreeSet<_>) = (listed.lines().collect(), now.lines().collect());
    let gone = listed.lines().filter(|line| !new.contains(line)).map(|line| format!("- {line}"));
    let came = now.lines().filter(|line| !old.contains(line)).map(|line| format!("+ {line}"));
    gone.chain(came).collect()
}
