//! The laws of a scene file's bodies.

use std::any::Any;

use contact_fem::element::{Element, Order, P1, P2};
use contact_fem::material::Volumetric;
use contact_fem::{
    Body, LinearElastic, Material, Mesh, MooneyRivlin, NeoHookean, Ogden, PlaneStress,
    StVenantKirchhoff,
};
use serde::Deserialize;

use super::keys::{BodyKeys, Name};
use super::{Error, of};

#[derive(Clone, Copy, Debug, Deserialize, PartialEq)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Law {
    LinearElastic,
    NeoHookean,
    StVenantKirchhoff,
    MooneyRivlin,
    Ogden,
}

impl Law {
    /// As in a file.
    fn name(self) -> &'static str {
        match self {
            Law::LinearElastic => "linear-elastic",
            Law::NeoHookean => "neo-hookean",
            Law::StVenantKirchhoff => "st-venant-kirchhoff",
            Law::MooneyRivlin => "mooney-rivlin",
            Law::Ogden => "ogden",
        }
    }
}

/// The constants of a region, of the body's law.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RegionKeys {
    region: Name,
    young: Option<f64>,
    poisson: Option<f64>,
    share: Option<f64>,
    terms: Option<Vec<[f64; 2]>>,
}

/// The constants of a law, those that are given.
struct Constants<'a> {
    part: &'a str,
    law: Law,
    young: Option<f64>,
    poisson: Option<f64>,
    share: Option<f64>,
    terms: Option<&'a [[f64; 2]]>,
}

impl Constants<'_> {
    fn error(&self, what: String) -> Error {
        let part = self.part.into();
        Error::Part { part, what }
    }

    fn given<T>(&self, key: &str, value: Option<T>) -> Result<T, Error> {
        let missing = || self.error(format!("the law {} needs `{key}`", self.law.name()));
        value.ok_or_else(missing)
    }

    /// Young's modulus and Poisson's ratio.
    fn moduli(&self) -> Result<(f64, f64), Error> {
        let young = self.given("young", self.young)?;
        Ok((young, self.given("poisson", self.poisson)?))
    }

    /// Refuses constants that the law does not have.
    fn check(&self) -> Result<(), Error> {
        let not_of = |key: &str, others: &str| {
            Err(self.error(format!("`{key}` is of {others}: leave it out")))
        };
        let is = |law: Law| self.law == law;
        if is(Law::Ogden) && self.young.is_some() {
            return not_of(
                "young",
                "laws other than ogden, whose modulus is (1 + ν) times the sum of its terms' products",
            );
        }
        if !is(Law::MooneyRivlin) && self.share.is_some() {
            return not_of("share", "the law mooney-rivlin");
        }
        if !is(Law::Ogden) && self.terms.is_some() {
            return not_of("terms", "the law ogden");
        }
        Ok(())
    }
}

/// A body of the law that its keys name.
pub(super) fn body<const D: usize>(
    part: &str,
    keys: &BodyKeys,
    mesh: Mesh<D>,
) -> Result<Body<D>, Error>
where
    P1: Element<D>,
    P2: Element<D>,
{
    let moduli = |c: &Constants| c.moduli();
    match keys.law {
        Law::LinearElastic => volumetric(part, keys, mesh, |c| {
            let (young, poisson) = moduli(c)?;
            of(c.part, LinearElastic::new(young, poisson))
        }),
        Law::NeoHookean => volumetric(part, keys, mesh, |c| {
            let (young, poisson) = moduli(c)?;
            of(c.part, NeoHookean::new(young, poisson))
        }),
        Law::MooneyRivlin => volumetric(part, keys, mesh, |c| {
            let (young, poisson) = moduli(c)?;
            let share = c.given("share", c.share)?;
            of(c.part, MooneyRivlin::new(young, poisson, share))
        }),
        Law::Ogden => volumetric(part, keys, mesh, |c| {
            let terms = c.given("terms", c.terms)?;
            let poisson = c.given("poisson", c.poisson)?;
            of(c.part, Ogden::new(terms, poisson))
        }),
        Law::StVenantKirchhoff if keys.averaged_volumes => Err(Error::Part {
            part: part.into(),
            what: "`averaged-volumes` is not for st-venant-kirchhoff, whose energy has no part of the volume alone: leave it \
                   out, or take another law"
                .into(),
        }),
        Law::StVenantKirchhoff => elastic(part, keys, mesh, |c| {
            let (young, poisson) = moduli(c)?;
            of(c.part, StVenantKirchhoff::new(young, poisson))
        }),
    }
}

/// A body, with averaged changes of volume or without.
fn volumetric<const D: usize, L: Volumetric<D> + Material<3>>(
    part: &str,
    keys: &BodyKeys,
    mesh: Mesh<D>,
    law: impl Fn(&Constants) -> Result<L, Error>,
) -> Result<Body<D>, Error>
where
    P1: Element<D>,
    P2: Element<D>,
{
    if !keys.averaged_volumes {
        return elastic(part, keys, mesh, law);
    }
    let refused = |what: &str| {
        let (part, what) = (part.into(), format!("`averaged-volumes` is {what}"));
        Err(Error::Part { part, what })
    };
    if mesh.order() == Order::Quadratic {
        return refused(
            "for linear cells, and these are quadratic, which do not lock: leave it or `quadratic` out",
        );
    }
    if keys.plane_stress {
        return refused("not for `plane-stress`, where nothing locks: leave it out");
    }
    if !keys.laws.is_empty() {
        return refused("for one law, and `laws` are several: leave it out, or take `quadratic`");
    }
    let law = law(&of_body(part, keys)?)?;
    of(part, Body::with_averaged_volumes(mesh, law))
}

/// A body in plane strain or space, or in plane stress.
fn elastic<const D: usize, L: Material<D> + Material<3>>(
    part: &str,
    keys: &BodyKeys,
    mesh: Mesh<D>,
    law: impl Fn(&Constants) -> Result<L, Error>,
) -> Result<Body<D>, Error>
where
    P1: Element<D>,
    P2: Element<D>,
{
    if !keys.plane_stress {
        return plain(part, keys, mesh, law);
    }
    // D is known to be 2 where the mesh is one of the plane
    let mesh: Box<dyn Any> = Box::new(mesh);
    let body: Option<Box<dyn Any>> = match mesh.downcast::<Mesh<2>>() {
        Ok(mesh) => Some(Box::new(sheet(part, keys, *mesh, law)?)),
        Err(_) => None,
    };
    let body = body.and_then(|body| body.downcast::<Body<D>>().ok());
    body.map(|body| *body).ok_or_else(|| Error::Part {
        part: part.into(),
        what: "`plane-stress` is for meshes of the plane: leave it out".into(),
    })
}

/// A body in plane stress.
fn sheet<L: Material<3>>(
    part: &str,
    keys: &BodyKeys,
    mesh: Mesh<2>,
    law: impl Fn(&Constants) -> Result<L, Error>,
) -> Result<Body<2>, Error> {
    plain(part, keys, mesh, |c| Ok(PlaneStress(law(c)?)))
}

/// A body of one law, or of one a region.
fn plain<const D: usize, L: Material<D>>(
    part: &str,
    keys: &BodyKeys,
    mesh: Mesh<D>,
    law: impl Fn(&Constants) -> Result<L, Error>,
) -> Result<Body<D>, Error>
where
    P1: Element<D>,
    P2: Element<D>,
{
    if keys.laws.is_empty() {
        return Ok(Body::new(mesh, law(&of_body(part, keys)?)?));
    }
    let own = [keys.young, keys.poisson, keys.share];
    if own.iter().any(Option::is_some) || keys.terms.is_some() {
        let what = "each of its `laws` has constants of its own: give `young`, `poisson`, `share` and `terms` there alone";
        return Err(Error::Part {
            part: part.into(),
            what: what.into(),
        });
    }
    let one = |keys_of_region: &RegionKeys| {
        let name = keys_of_region.region.to_string();
        let part = format!("{part}, region {name}");
        let constants = Constants {
            part: &part,
            law: keys.law,
            young: keys_of_region.young,
            poisson: keys_of_region.poisson,
            share: keys_of_region.share,
            terms: keys_of_region.terms.as_deref(),
        };
        constants.check()?;
        Ok((name, law(&constants)?))
    };
    let laws: Vec<(String, L)> = keys.laws.iter().map(one).collect::<Result<_, Error>>()?;
    of(part, Body::with_laws(mesh, laws))
}

/// The constants of a body of one law.
fn of_body<'a>(part: &'a str, keys: &'a BodyKeys) -> Result<Constants<'a>, Error> {
    let constants = Constants {
        part,
        law: keys.law,
        young: keys.young,
        poisson: keys.poisson,
        share: keys.share,
        terms: keys.terms.as_deref(),
    };
    constants.check()?;
    Ok(constants)
}
