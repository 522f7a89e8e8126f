//! Which source file names which.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use crate::file::File;
use crate::{Graph, Names};

/// The files of a crate by their modules; `lib.rs` and `main.rs` are both the root.
#[derive(Default)]
pub struct Crate(BTreeMap<Names, File>);

/// No item is passed on by more imports.
const MOST_IMPORTS: usize = 10;

impl Crate {
    /// The files below the folder `src`.
    pub fn read(src: &Path) -> Self {
        let (mut folders, mut files) = (vec![src.to_owned()], Vec::new());
        while let Some(folder) = folders.pop() {
            for entry in std::fs::read_dir(folder).unwrap() {
                let path = entry.unwrap().path();
                if path.is_dir() {
                    folders.push(path);
                } else if path.extension().is_some_and(|ending| ending == "rs") {
                    let text = std::fs::read_to_string(&path).unwrap();
                    files.push((path.strip_prefix(src).unwrap().to_owned(), text));
                }
            }
        }
        Self::of(files)
    }

    /// The files of these texts, by their paths below `src`, without those that only tests have.
    pub fn of(files: impl IntoIterator<Item = (PathBuf, String)>) -> Self {
        let mut all: BTreeMap<Names, File> = BTreeMap::new();
        for (path, text) in files {
            let names = path.with_extension("");
            let mut module: Names = names.iter().map(|name| name.to_string_lossy().into_owned()).collect();
            module.pop_if(|name| ["mod", "lib", "main"].contains(&name.as_str()));
            all.entry(module).or_default().read(&text);
        }
        let below = |module: &Names, name: &String| [&module[..], std::slice::from_ref(name)].concat();
        let tests = all.iter().flat_map(|(module, file)| file.tests.iter().map(|name| below(module, name)));
        let tests: Vec<Names> = tests.collect();
        all.retain(|module, _| !tests.iter().any(|test| module.starts_with(test)));
        Self(all)
    }

    /// Which file names which others, but for its parents and children.
    pub fn graph(&self) -> Graph {
        let named = self.0.iter().map(|(module, file)| {
            let paths = file.imports.iter().map(|(_, path)| path).chain(&file.paths);
            let homes = paths.filter_map(|path| self.home(module, path, 0));
            let others = homes.filter(|home| !home.starts_with(module) && !module.starts_with(home));
            (module.clone(), others.collect())
        });
        named.collect()
    }

    /// The module of the file that holds what `module` calls `path`; `None` for what other crates hold.
    fn home(&self, module: &[String], path: &[String], imports: usize) -> Option<Names> {
        let (mut at, mut rest) = (module.to_vec(), path);
        while let [first, after @ ..] = rest {
            match first.as_str() {
                "crate" => at.clear(),
                "super" => drop(at.pop()?),
                "self" => {}
                name if self.0.contains_key(&[&at[..], &[name.to_owned()]].concat()) => {
                    at.push(name.to_owned());
                }
                _ => break,
            }
            rest = after;
        }
        let is_ours = rest.len() < path.len();
        let (Some((item, after)), Some(file)) = (rest.split_first(), self.0.get(&at)) else {
            return is_ours.then_some(at);
        };
        if file.items.contains(item) || imports == MOST_IMPORTS {
            return Some(at);
        }
        let imported = file.imports.iter().find_map(|(name, import)| match name.as_str() {
            _ if import == path => None,
            "*" => self.home(&at, import, imports + 1).filter(|home| self.0[home].items.contains(item)),
            name if name == item => self.home(&at, &[&import[..], after].concat(), imports + 1),
            _ => None,
        });
        imported.or(is_ours.then_some(at))
    }
}
