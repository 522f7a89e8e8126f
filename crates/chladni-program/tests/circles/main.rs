//! No circle of files: below a file lies all that it names, but for a parent and its children, who may name each other.

#![allow(clippy::unwrap_used, reason = "a panic is how a test fails")]

mod file;
mod source;

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use source::Crate;

/// A path of names: that of a module, or of an item in one.
type Names = Vec<String>;
/// Which files name which others, by their modules.
type Graph = BTreeMap<Names, BTreeSet<Names>>;

#[test]
fn files_that_name_each_other_are_parent_and_child() {
    let above = Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(2).unwrap();
    let crates = std::fs::read_dir(above.join("crates")).unwrap().map(|entry| entry.unwrap().path());
    let homes: Vec<PathBuf> = crates.chain(["python", "web"].map(|home| above.join(home))).collect();
    assert!(homes.len() > 10, "{homes:?}");
    let mut found = Vec::new();
    for home in homes {
        let of = home.file_name().unwrap().to_string_lossy().into_owned();
        let graph = Crate::read(&home.join("src")).graph();
        found.extend(in_circles(&graph).into_iter().map(|(file, named)| {
            let named: Vec<String> = named.iter().map(|names| names.join("::")).collect();
            format!("{of}: {} names {}", file.join("::"), named.join(", "))
        }));
    }
    assert!(found.is_empty(), "files that name each other in a circle:\n{}", found.join("\n"));
}

/// The files that lie in circles, each with those that it names there.
fn in_circles(graph: &Graph) -> Graph {
    let reached = graph.keys().map(|from| {
        let (mut reached, mut next) = (BTreeSet::new(), vec![from]);
        while let Some(file) = next.pop() {
            next.extend(graph[file].iter().filter(|named| reached.insert(*named)));
        }
        (from, reached)
    });
    let reached: BTreeMap<&Names, BTreeSet<&Names>> = reached.collect();
    let back = graph.iter().map(|(file, named)| {
        let back = named.iter().filter(|named| reached[named].contains(file));
        (file.clone(), back.cloned().collect::<BTreeSet<_>>())
    });
    back.filter(|(_, named)| !named.is_empty()).collect()
}

#[test]
fn a_circle_is_found_and_what_leads_to_it_is_not() {
    let circles = |edges: &[[&str; 2]]| {
        let mut graph = Graph::new();
        for [from, to] in edges.iter().map(|edge| edge.map(|name| vec![name.to_owned()])) {
            graph.entry(to.clone()).or_default();
            graph.entry(from).or_default().insert(to);
        }
        in_circles(&graph).into_keys().flatten().collect::<String>()
    };
    assert_eq!(circles(&[["a", "b"], ["b", "c"], ["a", "c"]]), "");
    assert_eq!(circles(&[["a", "b"], ["b", "c"], ["c", "d"], ["d", "b"], ["d", "e"]]), "bcd");
}

#[test]
fn a_file_names_where_a_thing_is_and_not_who_passes_it_on() {
    let files = [
        ("lib.rs", "mod a; mod b; pub use a::Shape; pub use b::*;"),
        ("a/mod.rs", "mod deep; pub use deep::Shape; pub fn area() {}"),
        (
            "a/deep.rs",
            "use super::area; pub struct Shape; impl Shape { fn grown(&self) { crate::grow(self) } }",
        ),
        ("b.rs", "use crate::Shape; pub fn grow(shape: &Shape) {}"),
        ("c.rs", "use crate::a; fn f() { a::Shape::grown() } #[cfg(test)] mod tests { use crate::b; }"),
    ];
    let graph = Crate::of(files.map(|(path, text)| (PathBuf::from(path), text.to_owned()))).graph();
    let named = |file: &str| {
        let file: Names = file.split("::").map(str::to_owned).collect();
        graph[&file].iter().map(|names| names.join("::")).collect::<Vec<_>>()
    };
    assert_eq!(named("b"), ["a::deep"]);
    assert_eq!(named("a::deep"), ["b"], "its parent does not count");
    assert_eq!(named("c"), ["a", "a::deep"], "its tests do not count");
    let circle: Vec<Names> = in_circles(&graph).into_keys().collect();
    assert_eq!(circle, [vec!["a".to_owned(), "deep".to_owned()], vec!["b".to_owned()]]);
}
