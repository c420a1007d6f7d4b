//! Lengths of files and functions.

use std::path::Path;

use syn::spanned::Spanned as _;
use syn::visit::{Visit, visit_block, visit_file};

use super::{parsed, rust_files};

const MAX_FILE_LINES: usize = 400;
const MAX_FUNCTION_LINES: usize = 70;
const FOLDERS: [&str; 4] = ["src", "tests", "examples", "benches"];

/// Collects functions that are too long.
#[derive(Default)]
struct LongFunctions(Vec<String>);

impl LongFunctions {
    fn check(&mut self, signature: &syn::Signature, block: &syn::Block) {
        let lines = block.span().end().line - signature.span().start().line + 1;
        if lines > MAX_FUNCTION_LINES {
            self.0.push(format!("{} has {lines} lines", signature.ident));
        }
    }
}

impl<'ast> Visit<'ast> for LongFunctions {
    fn visit_item_fn(&mut self, function: &'ast syn::ItemFn) {
        self.check(&function.sig, &function.block);
        visit_block(self, &function.block);
    }

    fn visit_impl_item_fn(&mut self, function: &'ast syn::ImplItemFn) {
        self.check(&function.sig, &function.block);
        visit_block(self, &function.block);
    }
}

#[test]
fn files_and_functions_are_short() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut too_long = Vec::new();
    for file in FOLDERS.iter().flat_map(|folder| rust_files(&root.join(folder))) {
        let name = file.strip_prefix(root).unwrap().display();
        let lines = std::fs::read_to_string(&file).unwrap().lines().count();
        if lines > MAX_FILE_LINES {
            too_long.push(format!("{name}: {lines} lines"));
        }
        let mut functions = LongFunctions::default();
        visit_file(&mut functions, &parsed(&file));
        too_long.extend(functions.0.iter().map(|function| format!("{name}: {function}")));
    }
    assert!(
        too_long.is_empty(),
        "over {MAX_FILE_LINES} lines a file or {MAX_FUNCTION_LINES} a function:\n{}",
        too_long.join("\n")
    );
}
