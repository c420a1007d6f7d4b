//! Import cycles between files.
//!
//! A file imports another when a path in it names an item that the other defines. Re-exports are followed to the file that
//! defines the item, so that a `mod.rs` that only re-exports is nobody's import. Code in `#[cfg(test)]` does not count.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use syn::visit::{Visit, visit_path};
use syn::{ItemMod, ItemUse, UseTree, Visibility};

use super::{ModulePath, modules, parsed};

/// What one file names of others.
#[derive(Default)]
struct Names {
    /// Names that are re-exported, with the path each is an alias of.
    reexports: BTreeMap<String, Vec<String>>,
    /// Names that `use` brings into scope, likewise.
    scope: BTreeMap<String, Vec<String>>,
    /// Paths of at least two segments in items and expressions.
    paths: Vec<Vec<String>>,
}

impl Names {
    fn add_use(&mut self, prefix: &[String], tree: &UseTree, is_reexport: bool) {
        let joined = |name: String| [prefix, &[name]].concat();
        let (name, path) = match tree {
            UseTree::Path(path) => {
                return self.add_use(&joined(path.ident.to_string()), &path.tree, is_reexport);
            }
            UseTree::Group(group) => {
                return group.items.iter().for_each(|tree| self.add_use(prefix, tree, is_reexport));
            }
            UseTree::Name(name) if name.ident == "self" => {
                (prefix.last().cloned().unwrap_or_default(), prefix.to_vec())
            }
            UseTree::Name(name) => (name.ident.to_string(), joined(name.ident.to_string())),
            UseTree::Rename(rename) => (rename.rename.to_string(), joined(rename.ident.to_string())),
            UseTree::Glob(_) => return,
        };
        let names = if is_reexport { &mut self.reexports } else { &mut self.scope };
        names.insert(name, path);
    }
}

fn is_test(attributes: &[syn::Attribute]) -> bool {
    attributes.iter().any(|attribute| {
        attribute.path().is_ident("cfg")
            && attribute.meta.require_list().is_ok_and(|list| list.tokens.to_string() == "test")
    })
}

impl<'ast> Visit<'ast> for Names {
    fn visit_item_use(&mut self, item: &'ast ItemUse) {
        if !is_test(&item.attrs) {
            self.add_use(&[], &item.tree, !matches!(item.vis, Visibility::Inherited));
        }
    }

    fn visit_item_mod(&mut self, item: &'ast ItemMod) {
        if !is_test(&item.attrs) {
            syn::visit::visit_item_mod(self, item);
        }
    }

    /// `pub(in path)` is no import.
    fn visit_visibility(&mut self, _: &'ast Visibility) {}

    fn visit_path(&mut self, path: &'ast syn::Path) {
        if path.segments.len() > 1 {
            self.paths.push(path.segments.iter().map(|segment| segment.ident.to_string()).collect());
        }
        visit_path(self, path);
    }
}

/// The files of a crate and what they name.
struct SourceTree {
    files: BTreeMap<ModulePath, PathBuf>,
    names: BTreeMap<ModulePath, Names>,
}

impl SourceTree {
    fn read(folder: &Path, root: &str) -> Self {
        let files = modules(folder, root);
        let names = files.iter().map(|(module, file)| {
            let mut names = Names::default();
            names.visit_file(&parsed(file));
            (module.clone(), names)
        });
        Self { names: names.collect(), files }
    }

    /// The module whose file defines what `path` names in `module`; `None` for other crates, modules and locals.
    fn defined_in(&self, module: &[String], path: &[String], depth: usize) -> Option<ModulePath> {
        let mut here = module.to_vec();
        let mut rest = path;
        match path.first().map(String::as_str) {
            Some("crate") => (here, rest) = (Vec::new(), &path[1..]),
            Some("self") => rest = &path[1..],
            Some("super") => {
                while rest.first().is_some_and(|segment| segment == "super") {
                    here.pop()?;
                    rest = &rest[1..];
                }
            }
            Some(first) if self.files.contains_key(&[module, &[first.to_owned()]].concat()) => {}
            _ => return None,
        }
        while let Some((first, others)) = rest.split_first() {
            let child = [here.as_slice(), std::slice::from_ref(first)].concat();
            if self.files.contains_key(&child) {
                (here, rest) = (child, others);
                continue;
            }
            let target = self.names.get(&here)?.reexports.get(first);
            return match target {
                Some(target) if depth < 16 => {
                    self.defined_in(&here, &[target.as_slice(), others].concat(), depth + 1)
                }
                _ => Some(here),
            };
        }
        None
    }

    /// The modules whose items the file of `module` names.
    fn imports(&self, module: &ModulePath) -> BTreeSet<ModulePath> {
        let names = &self.names[module];
        let through_scope = names.paths.iter().map(|path| match names.scope.get(&path[0]) {
            Some(scope) => [scope.as_slice(), &path[1..]].concat(),
            None => path.clone(),
        });
        let paths = names.scope.values().cloned().chain(through_scope);
        let targets = paths.filter_map(|path| self.defined_in(module, &path, 0));
        // The crate's root defines nothing but the list of modules.
        targets.filter(|target| target != module && !target.is_empty()).collect()
    }

    /// The files that can reach themselves by imports, with what they import on the way.
    fn cycles(&self) -> Vec<String> {
        let imports: BTreeMap<_, _> =
            self.files.keys().map(|module| (module.clone(), self.imports(module))).collect();
        let reachable = |from: &ModulePath| {
            let (mut seen, mut pending) = (BTreeSet::new(), vec![from]);
            while let Some(next) = pending.pop() {
                pending.extend(imports[next].iter().filter(|target| seen.insert((*target).clone())));
            }
            seen
        };
        let reachable: BTreeMap<_, _> = self.files.keys().map(|module| (module, reachable(module))).collect();
        let mut cycles = Vec::new();
        for (module, file) in &self.files {
            for target in &imports[module] {
                if reachable[target].contains(module) {
                    cycles.push(format!("{} imports {}", file.display(), self.files[target].display()));
                }
            }
        }
        cycles
    }
}

#[test]
fn no_two_files_import_each_other() {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    for root in ["lib", "main"] {
        let tree = SourceTree::read(&source, root);
        assert!(tree.files.len() > 100, "{} files", tree.files.len());
        let cycles = tree.cycles();
        assert!(cycles.is_empty(), "{} imports are part of cycles:\n{}", cycles.len(), cycles.join("\n"));
    }
}

#[test]
fn a_cycle_through_a_reexport_is_found() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    std::fs::create_dir(folder.path().join("a")).unwrap();
    write("lib.rs", "pub mod a; pub mod b;");
    write("a/mod.rs", "mod c; pub use c::C;");
    write("a/c.rs", "use crate::b; pub struct C(b::B);");
    write("b.rs", "pub struct B; fn f(c: &crate::a::C) {}");
    let cycles = SourceTree::read(folder.path(), "lib").cycles();
    assert_eq!(cycles.len(), 2, "{cycles:?}");
    write("b.rs", "pub struct B; #[cfg(test)] mod tests { use crate::a::C; }");
    assert_eq!(SourceTree::read(folder.path(), "lib").cycles(), Vec::<String>::new());
}
