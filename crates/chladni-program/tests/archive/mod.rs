//! Arrays read back out of NumPy archives.
#![allow(dead_code, reason = "each test file uses some of it")]

use std::fs::File;
use std::io::Read;
use std::path::Path;

use npyz::{DType, NpyFile, TypeChar};

/// One array of numbers.
#[derive(Clone, Debug, PartialEq)]
pub struct Array {
    pub shape: Vec<u64>,
    /// In the order in which the file has them.
    pub values: Vec<f64>,
}

/// The names of the arrays at `path`.
pub fn names(path: &Path) -> Vec<String> {
    let archive = zip::ZipArchive::new(File::open(path).unwrap()).unwrap();
    let names = archive.file_names().filter_map(Result::ok);
    names.filter_map(|name| name.strip_suffix(".npy").map(str::to_owned)).collect()
}

/// The array `name`, `None` where there is none or it holds no numbers.
pub fn array(path: &Path, name: &str) -> Option<Array> {
    let mut archive = zip::ZipArchive::new(File::open(path).unwrap()).unwrap();
    let member = archive.by_name(&format!("{name}.npy")).ok()?;
    let file = NpyFile::new(member).unwrap();
    let shape = file.shape().to_vec();
    let DType::Plain(kind) = file.dtype() else { return None };
    let values = match (kind.type_char(), kind.size_field()) {
        (TypeChar::Float, 4) => numbers::<f32>(file),
        (TypeChar::Float, 8) => file.into_vec().unwrap(),
        (TypeChar::Int, 4) => numbers::<i32>(file),
        (TypeChar::Uint, 4) => numbers::<u32>(file),
        (TypeChar::Int, 1) => numbers::<i8>(file),
        (TypeChar::Uint, 1) => numbers::<u8>(file),
        (TypeChar::Int, 8) => file.into_vec::<i64>().unwrap().into_iter().map(|x| x as f64).collect(),
        (TypeChar::Uint, 8) => file.into_vec::<u64>().unwrap().into_iter().map(|x| x as f64).collect(),
        _ => return None,
    };
    Some(Array { shape, values })
}

fn numbers<T: npyz::Deserialize + Into<f64>>(file: NpyFile<impl Read>) -> Vec<f64> {
    file.into_vec::<T>().unwrap().into_iter().map(Into::into).collect()
}
