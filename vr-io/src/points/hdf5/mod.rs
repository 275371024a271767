//! Points in HDF5: snapshots of the Gadget family (Gadget, Arepo, SWIFT, GIZMO), and dumps of Phantom.

mod source;

use std::path::Path;

use glam::DVec3;

use crate::error::{FileErrorKind, shown};
use crate::scalar::Endian;

use super::roles::Roles;
use super::{Column, Found, Numbering, PointOptions, Table, numbers};

use source::Source;

/// True if a file holds particles as one of these codes writes them, or cannot be read, which [`read`] explains.
pub(crate) fn holds_points(path: &Path) -> bool {
    let groups = Source::open(path).and_then(|source| source.groups("/"));
    groups.map_or(true, |groups| groups.iter().any(|g| g == "particles" || g.starts_with("PartType")))
}

pub(super) fn read(path: &Path, options: &PointOptions) -> Result<Found, FileErrorKind> {
    let source = Source::open(path)?;
    let groups = source.groups("/")?;
    // Gas comes first; snapshots of dark matter have none.
    let gadget = (0..6).map(|kind| (kind, format!("PartType{kind}")));
    let gadget = gadget.filter(|(_, name)| groups.contains(name)).collect::<Vec<_>>();
    if let Some((kind, group)) = gadget.first() {
        let mut snapshot = Snapshot::new(&source, group, "Coordinates")?;
        for (_, other) in &gadget[1..] {
            snapshot.notes.push(format!("{other} is left out: {group} is taken"));
        }
        let mass = source.list("/Header", "MassTable")?.and_then(|table| table.get(*kind).copied());
        // Where all are equal, the header tells; 0 says that each has its own.
        if let Some(mass) = mass.filter(|&mass| mass > 0.0) {
            snapshot.derive("Masses", |count| vec![mass; count]);
        }
        return snapshot.into_found("HDF5 (Gadget)", options);
    }
    if groups.iter().any(|g| g == "particles") {
        return phantom(&source)?.into_found("HDF5 (Phantom)", options);
    }
    let allowed = "must hold a group PartType0 with Coordinates (Gadget), or particles with xyz (Phantom)";
    Err(FileErrorKind::field("groups", groups.join(", "), allowed))
}

/// A dump of Phantom (Price et al. 2018, "Phantom: a smoothed particle hydrodynamics and magnetohydrodynamics code for astrophysics"): particles
/// of one kind have one mass, and densities are told by smoothing lengths, ρ = m (hfact / h)³.
fn phantom<'s>(source: &'s Source) -> Result<Snapshot<'s>, FileErrorKind> {
    /// The kind of gas.
    const GAS: f64 = 1.0;
    let mut snapshot = Snapshot::new(source, "particles", "xyz")?;
    let mass = source.list("/header", "massoftype")?.and_then(|masses| masses.first().copied());
    let hfact = source.list("/header", "hfact")?.and_then(|hfact| hfact.first().copied());
    if let (Some(mass), Some(hfact)) = (mass.filter(|&mass| mass > 0.0), hfact) {
        let h = if snapshot.names.iter().any(|n| n == "h") { snapshot.load("h")? } else { Vec::new() };
        snapshot.derive("mass", |count| vec![mass; count]);
        if h.len() == snapshot.positions.len() {
            snapshot.derive("density", |_| h.iter().map(|h| mass * (hfact / h).powi(3)).collect());
            snapshot.notes.push("densities: mass (hfact / h)^3".to_owned());
        }
    }
    if snapshot.names.iter().any(|n| n == "itype") {
        let kinds = snapshot.load("itype")?;
        snapshot.kept = Some((0..kinds.len()).filter(|&k| kinds[k] == GAS).collect());
        let others = kinds.iter().filter(|&&kind| kind != GAS).count();
        if others > 0 {
            snapshot.notes.push(format!("{others} particles are left out: their itype is not 1, gas"));
        }
    }
    Ok(snapshot)
}

/// A group of particles.
struct Snapshot<'s> {
    source: &'s Source,
    group: String,
    scalar: crate::ScalarType,
    positions: Vec<DVec3>,
    /// Datasets with one number for each particle, then what is derived.
    names: Vec<String>,
    derived: Vec<Column>,
    /// Indices of the points that count, if not all do.
    kept: Option<Vec<usize>>,
    notes: Vec<String>,
}

impl<'s> Snapshot<'s> {
    fn new(source: &'s Source, group: &str, positions: &str) -> Result<Self, FileErrorKind> {
        let path = format!("/{group}/{positions}");
        let (shape, scalar, all) = source.numbers(&path)?;
        if !matches!(shape[..], [_, 3]) {
            return Err(FileErrorKind::field(path, format!("{shape:?}"), "must be of shape [N, 3]"));
        }
        let positions = numbers::positions(&all);
        let names = source.columns(group, positions.len() as u64)?;
        let (group, notes) = (group.to_owned(), Vec::new());
        Ok(Self { source, group, scalar, positions, names, derived: Vec::new(), kept: None, notes })
    }

    fn load(&self, name: &str) -> Result<Vec<f64>, FileErrorKind> {
        let (_, _, numbers) = self.source.numbers(&format!("/{}/{name}", self.group))?;
        Ok(numbers)
    }

    /// Adds a column, unless the file has it.
    fn derive(&mut self, name: &str, numbers: impl FnOnce(usize) -> Vec<f64>) {
        if !self.names.iter().any(|n| n == name) {
            let numbers = numbers(self.positions.len());
            self.derived.push(Column { name: name.to_owned(), numbers });
        }
    }

    fn into_found(self, format: &'static str, options: &PointOptions) -> Result<Found, FileErrorKind> {
        let own = self.names.len();
        let names: Vec<String> =
            self.names.iter().map(|name| shown(name)).chain(self.derived.iter().map(|c| c.name.clone())).collect();
        let keep = |numbers: Vec<f64>| match &self.kept {
            Some(kept) => kept.iter().filter_map(|&k| numbers.get(k).copied()).collect(),
            None => numbers,
        };
        let columns = Roles::choose(&names, options)?.try_map(|i| {
            let numbers = match i.checked_sub(own) {
                Some(derived) => self.derived[derived].numbers.clone(),
                None => self.load(&self.names[i])?,
            };
            Ok::<_, FileErrorKind>(Column { name: names[i].clone(), numbers: keep(numbers) })
        })?;
        let (positions, numbering) = match &self.kept {
            Some(kept) => {
                let positions = kept.iter().filter_map(|&k| self.positions.get(k).copied()).collect();
                (positions, Numbering::Points(kept.clone()))
            }
            None => (self.positions, Numbering::FromZero),
        };
        let table = Table { positions, columns, numbering };
        Ok(Found {
            table,
            format,
            encoding: "HDF5",
            scalar: self.scalar,
            endian: Endian::NATIVE,
            names,
            notes: self.notes,
        })
    }
}
