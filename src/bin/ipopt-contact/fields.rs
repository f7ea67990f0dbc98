//! `ipopt-contact fields RESULT`: a result as arrays that a script of FreeFEM reads.

use std::path::Path;
use std::process::ExitCode;

use ipopt_contact::contact_fem::freefem::array_text;
use ipopt_contact::contact_fem::output::compare::{fields_at, nodes_of};
use ipopt_contact::contact_fem::output::record::print;

use crate::{Words, solve::write};

/// Writes `u_BODY.txt` and `f_BODY.txt`.
pub fn command(words: &[String]) -> Result<ExitCode, String> {
    let words = Words::parse("fields", words, &["nodes", "out"], &[])?;
    let result = Path::new(words.only("one folder of a result")?);
    let out = Path::new(words.needed("out")?);
    let order = nodes_of(Path::new(words.needed("nodes")?));
    let (dimension, nodes) = order.map_err(|why| why.to_string())?;
    let fields = fields_at(result, dimension, &nodes).map_err(|why| {
        let (asked, result) = (words.option("nodes").unwrap_or_default(), result.display());
        format!("{why} (A is {asked}, B is {result})")
    })?;
    let interleaved = |vectors: &[[f64; 3]]| -> Vec<f64> {
        let components = vectors.iter().flat_map(|v| &v[..dimension]);
        components.copied().collect()
    };
    for field in fields {
        let body = &field.body;
        let u = interleaved(&field.displacements);
        print(write(out, &format!("u_{body}.txt"), &array_text(&u))?);
        if let Some(forces) = &field.forces {
            let f = interleaved(forces);
            print(write(out, &format!("f_{body}.txt"), &array_text(&f))?);
        }
    }
    Ok(ExitCode::SUCCESS)
}
