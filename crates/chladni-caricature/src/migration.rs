//! Bringing project files of older formats up to date.

use std::path::Path;

use toml::{Table, Value};

use crate::Error;

/// The format that this program writes.
pub const FORMAT_VERSION: i64 = 2;

/// `table` in the current format, or `None` where it is already.
pub(crate) fn migrate(mut table: Table, path: &Path) -> Result<Option<Table>, Error> {
    let invalid = |why: &str| Error::ProjectFile { path: path.into(), why: why.to_owned() };
    let Some(version) = table.get("format_version").and_then(Value::as_integer) else {
        return Err(invalid("names no format_version; it is not a Chladni project"));
    };
    match version {
        FORMAT_VERSION => return Ok(None),
        1 => from_1_to_2(&mut table),
        found if found > FORMAT_VERSION => {
            return Err(Error::NewerFormat { path: path.into(), found, supported: FORMAT_VERSION });
        }
        _ => return Err(invalid(&format!("has format version {version}, which never existed"))),
    }
    table.insert("format_version".into(), Value::Integer(FORMAT_VERSION));
    Ok(Some(table))
}

/// In format 1 the shape was a single key, and a layer's region and scale curve were keys of the
/// layer itself: `spheres`, `cutoff` (always a sharp cut, never clamped), `curve` and `residual`.
fn from_1_to_2(table: &mut Table) {
    let shape = table.remove("shape").unwrap_or(Value::String(String::new()));
    let mut shape_table = Table::new();
    shape_table.insert("source".into(), shape);
    if let Some(harmonics) = table.remove("harmonics") {
        shape_table.insert("harmonics".into(), harmonics);
    }
    table.insert("shape".into(), Value::Table(shape_table));
    let Some(Value::Array(layers)) = table.get_mut("layer") else { return };
    for layer in layers.iter_mut().filter_map(Value::as_table_mut) {
        let mut region = Table::new();
        for key in ["spheres", "painted", "cutoff"] {
            region.extend(layer.remove(key).map(|value| (key.to_owned(), value)));
        }
        region.insert("roll_off".into(), Value::String("sharp".into()));
        region.insert("clamp".into(), Value::Boolean(false));
        layer.insert("region".into(), Value::Table(region));
        if let Some(points) = layer.remove("curve") {
            let residual = layer.remove("residual").unwrap_or(Value::Float(1.0));
            let scale = [("points".to_owned(), points), ("residual".to_owned(), residual)];
            layer.insert("scale".into(), Value::Table(scale.into_iter().collect()));
        }
    }
}
