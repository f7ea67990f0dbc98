//! The laws of a scene file's bodies.

use std::any::Any;

use contact_fem::element::{Element, Order, P1, P2};
use contact_fem::material::Volumetric;
use contact_fem::{
    Body, LinearElastic, Material, Mesh, MooneyRivlin, NeoHookean, Ogden, PlaneStress,
    StVenantKirchhoff,
};
use serde::Deserialize;

use super::Error;
use super::keys::{BodyKeys, RegionKeys};
use super::place::Place;

#[derive(Clone, Copy, Debug, Deserialize, PartialEq)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Law {
    LinearElastic,
    NeoHookean,
    StVenantKirchhoff,
    MooneyRivlin,
    Ogden,
    Rigid,
    RigidTurning,
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
            Law::Rigid => "rigid",
            Law::RigidTurning => "rigid-turning",
        }
    }
}

/// The constants of a law, those that are given.
struct Constants<'a> {
    place: Place<'a>,
    law: Law,
    young: Option<f64>,
    poisson: Option<f64>,
    share: Option<f64>,
    terms: Option<&'a [[f64; 2]]>,
}

impl Constants<'_> {
    fn given<T>(&self, key: &'static str, value: Option<T>) -> Result<T, Error> {
        let what = || format!("the law {} needs `{key}`", self.law.name());
        value.ok_or_else(|| self.place.key(key).wrong(what()))
    }

    /// Names the constant that a law refuses.
    fn law_of<T>(&self, law: Result<T, contact_fem::Error>) -> Result<T, Error> {
        use contact_fem::Error as Refused;
        let key = match (&law, self.law) {
            (Err(Refused::PoissonsRatio { .. } | Refused::ModuliApart { .. }), _) => "poisson",
            (_, Law::Ogden) => "terms",
            (Err(Refused::Setting { .. }), _) => "share",
            _ => "young",
        };
        self.place.key(key).of(law)
    }

    /// Young's modulus and Poisson's ratio.
    fn moduli(&self) -> Result<(f64, f64), Error> {
        let young = self.given("young", self.young)?;
        Ok((young, self.given("poisson", self.poisson)?))
    }

    /// Refuses constants that the law does not have.
    fn check(&self) -> Result<(), Error> {
        let not_of = |key: &'static str, others: &str| {
            let what = format!("`{key}` is of {others}: leave it out");
            Err(self.place.key(key).wrong(what))
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
    place: &Place<'_>,
    keys: &BodyKeys,
    mesh: Mesh<D>,
) -> Result<Body<D>, Error>
where
    P1: Element<D>,
    P2: Element<D>,
{
    let moduli = |c: &Constants| c.moduli();
    match keys.law {
        Law::LinearElastic => volumetric(place, keys, mesh, |c| {
            let (young, poisson) = moduli(c)?;
            c.law_of(LinearElastic::new(young, poisson))
        }),
        Law::NeoHookean => volumetric(place, keys, mesh, |c| {
            let (young, poisson) = moduli(c)?;
            c.law_of(NeoHookean::new(young, poisson))
        }),
        Law::MooneyRivlin => volumetric(place, keys, mesh, |c| {
            let (young, poisson) = moduli(c)?;
            let share = c.given("share", c.share)?;
            c.law_of(MooneyRivlin::new(young, poisson, share))
        }),
        Law::Ogden => volumetric(place, keys, mesh, |c| {
            let terms = c.given("terms", c.terms)?;
            let poisson = c.given("poisson", c.poisson)?;
            c.law_of(Ogden::new(terms, poisson))
        }),
        Law::Rigid | Law::RigidTurning => rigid(place, keys, mesh),
        Law::StVenantKirchhoff if keys.averaged_volumes => Err(place.key("averaged-volumes").wrong(
            "`averaged-volumes` is not for st-venant-kirchhoff, whose energy has no part of the volume alone: leave it \
             out, or take another law",
        )),
        Law::StVenantKirchhoff => elastic(place, keys, mesh, |c| {
            let (young, poisson) = moduli(c)?;
            c.law_of(StVenantKirchhoff::new(young, poisson))
        }),
    }
}

/// A body that does not deform.
fn rigid<const D: usize>(
    place: &Place<'_>,
    keys: &BodyKeys,
    mesh: Mesh<D>,
) -> Result<Body<D>, Error>
where
    P1: Element<D>,
    P2: Element<D>,
{
    let given = [
        ("young", keys.young.is_some()),
        ("poisson", keys.poisson.is_some()),
        ("share", keys.share.is_some()),
        ("terms", keys.terms.is_some()),
        ("laws", !keys.laws.is_empty()),
        ("averaged-volumes", keys.averaged_volumes),
        ("plane-stress", keys.plane_stress),
    ];
    if let Some((key, _)) = given.iter().find(|(_, is_given)| *is_given) {
        let what = format!("`{key}` is not of a rigid body, which does not deform: leave it out");
        return Err(place.key(*key).wrong(what));
    }
    let turns = keys.law == Law::RigidTurning;
    if keys.revolution {
        if turns {
            let what = "a body of revolution does not turn: take the law rigid";
            return Err(place.key("law").wrong(what));
        }
        return of_plane(place, "revolution", mesh, |mesh| {
            place.key("revolution").of(Body::rigid_of_revolution(mesh))
        });
    }
    Ok(match turns {
        true => Body::rigid_turning(mesh),
        false => Body::rigid(mesh),
    })
}

/// A body, with averaged changes of volume or without.
fn volumetric<const D: usize, L: Volumetric<D> + Material<3>>(
    place: &Place<'_>,
    keys: &BodyKeys,
    mesh: Mesh<D>,
    law: impl Fn(&Constants) -> Result<L, Error>,
) -> Result<Body<D>, Error>
where
    P1: Element<D>,
    P2: Element<D>,
{
    if !keys.averaged_volumes {
        return elastic(place, keys, mesh, law);
    }
    let refused = |what: &str| {
        let what = format!("`averaged-volumes` is {what}");
        Err(place.key("averaged-volumes").wrong(what))
    };
    if mesh.order() == Order::Quadratic {
        return refused(
            "for linear cells, and these are quadratic, which do not lock: leave it or `quadratic` out",
        );
    }
    if keys.plane_stress {
        return refused("not for `plane-stress`, where nothing locks: leave it out");
    }
    if keys.revolution {
        return refused(
            "not for `revolution`: leave it out, or take `quadratic`, which does not lock",
        );
    }
    if !keys.laws.is_empty() {
        return refused("for one law, and `laws` are several: leave it out, or take `quadratic`");
    }
    let law = law(&of_body(place, keys)?)?;
    place.of(Body::with_averaged_volumes(mesh, law))
}

/// A body in plane strain or space, in plane stress, or of revolution.
fn elastic<const D: usize, L: Material<D> + Material<3>>(
    place: &Place<'_>,
    keys: &BodyKeys,
    mesh: Mesh<D>,
    law: impl Fn(&Constants) -> Result<L, Error>,
) -> Result<Body<D>, Error>
where
    P1: Element<D>,
    P2: Element<D>,
{
    match (keys.plane_stress, keys.revolution) {
        (false, false) => plain(place, keys, mesh, law),
        (true, true) => {
            let what = "a body of revolution is no sheet: leave `plane-stress` or `revolution` out";
            Err(place.key("revolution").wrong(what))
        }
        (true, false) => of_plane(place, "plane-stress", mesh, |mesh| {
            sheet(place, keys, mesh, law)
        }),
        (false, true) => of_plane(place, "revolution", mesh, |mesh| {
            revolved(place, keys, mesh, law)
        }),
    }
}

/// A body of a mesh of the plane, which `key` asks for.
fn of_plane<const D: usize>(
    place: &Place<'_>,
    key: &'static str,
    mesh: Mesh<D>,
    body: impl FnOnce(Mesh<2>) -> Result<Body<2>, Error>,
) -> Result<Body<D>, Error> {
    // D is known to be 2 where the mesh is one of the plane
    let mesh: Box<dyn Any> = Box::new(mesh);
    let found: Option<Box<dyn Any>> = match mesh.downcast::<Mesh<2>>() {
        Ok(mesh) => Some(Box::new(body(*mesh)?)),
        Err(_) => None,
    };
    let found = found.and_then(|body| body.downcast::<Body<D>>().ok());
    found.map(|body| *body).ok_or_else(|| {
        let of = match key {
            "revolution" => "the half-plane r ≥ 0",
            _ => "the plane",
        };
        place
            .key(key)
            .wrong(format!("`{key}` is for meshes of {of}: leave it out"))
    })
}

/// A body in plane stress.
fn sheet<L: Material<3>>(
    place: &Place<'_>,
    keys: &BodyKeys,
    mesh: Mesh<2>,
    law: impl Fn(&Constants) -> Result<L, Error>,
) -> Result<Body<2>, Error> {
    plain(place, keys, mesh, |c| Ok(PlaneStress(law(c)?)))
}

/// A body of revolution.
fn revolved<L: Material<3>>(
    place: &Place<'_>,
    keys: &BodyKeys,
    mesh: Mesh<2>,
    law: impl Fn(&Constants) -> Result<L, Error>,
) -> Result<Body<2>, Error> {
    let at = place.key("revolution");
    match given(place, keys, law)? {
        Given::One(law) => at.of(Body::of_revolution(mesh, law)),
        Given::OfRegions(laws) => {
            let body = Body::of_revolution_with_laws(mesh, laws);
            match body {
                Err(why @ contact_fem::Error::NegativeRadius { .. }) => at.of(Err(why)),
                other => place.key("laws").of(other),
            }
        }
    }
}

/// A body of one law, or of one a region.
fn plain<const D: usize, L: Material<D>>(
    place: &Place<'_>,
    keys: &BodyKeys,
    mesh: Mesh<D>,
    law: impl Fn(&Constants) -> Result<L, Error>,
) -> Result<Body<D>, Error>
where
    P1: Element<D>,
    P2: Element<D>,
{
    match given(place, keys, law)? {
        Given::One(law) => Ok(Body::new(mesh, law)),
        Given::OfRegions(laws) => place.key("laws").of(Body::with_laws(mesh, laws)),
    }
}

/// One law, or one a region.
enum Given<L> {
    One(L),
    OfRegions(Vec<(String, L)>),
}

/// The laws that the keys of a body give.
fn given<L>(
    place: &Place<'_>,
    keys: &BodyKeys,
    law: impl Fn(&Constants) -> Result<L, Error>,
) -> Result<Given<L>, Error> {
    if keys.laws.is_empty() {
        return Ok(Given::One(law(&of_body(place, keys)?)?));
    }
    let own = [keys.young, keys.poisson, keys.share];
    if own.iter().any(Option::is_some) || keys.terms.is_some() {
        let what = "each of its `laws` has constants of its own: give `young`, `poisson`, `share` and `terms` there alone";
        return Err(place.key("laws").wrong(what));
    }
    let one = |(k, keys_of_region): (usize, &RegionKeys)| {
        let name = keys_of_region.region.to_string();
        let constants = Constants {
            place: place.entry("laws", k),
            law: keys.law,
            young: keys_of_region.young,
            poisson: keys_of_region.poisson,
            share: keys_of_region.share,
            terms: keys_of_region.terms.as_deref(),
        };
        constants.check()?;
        Ok((name, law(&constants)?))
    };
    let laws: Vec<(String, L)> = keys
        .laws
        .iter()
        .enumerate()
        .map(one)
        .collect::<Result<_, Error>>()?;
    Ok(Given::OfRegions(laws))
}

/// The constants of a body of one law.
fn of_body<'a>(place: &Place<'a>, keys: &'a BodyKeys) -> Result<Constants<'a>, Error> {
    let constants = Constants {
        place: place.clone(),
        law: keys.law,
        young: keys.young,
        poisson: keys.poisson,
        share: keys.share,
        terms: keys.terms.as_deref(),
    };
    constants.check()?;
    Ok(constants)
}
