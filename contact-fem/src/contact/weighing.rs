//! How the weights of integration points vary with the positions, for Newton's method.
//!
//! A weak gap c_i = ∫ φ_i g / ∫ φ_i (equation (5) of the paper) is taken over the part of the slave that is opposite the master. Where the master ends, so
//! does this part, and its end moves with the bodies: a row at a rim varies by φ_i (g − c_i)/a_i times the weight that it gains there, and its
//! force likewise moves from the middle of the row to the end, or back. The force changes so even while the gap is closed everywhere,
//! by λ/a_i times what is gained: where a stiff tool slides on a soft body, this stiffness exceeds the body's own.
//!
//! Two kinds of places gain weight:
//!
//! - In the plane, pieces of cut facets end where the normal n of the master's last node x̄ meets the slave's facet, at the t at which
//!   (x(t) − x̄)×n = 0. The end gains |X,t| δt, δt = −((δx − δx̄)×n + (x − x̄)×δn)/(x,t×n), or loses it. Where pieces meet elsewhere,
//!   one gains what the other loses.
//! - Gauss points fade near a rim, in proportion to the [depth](super::rim::Rim::depth) of their feet.
//!
//! Left out are the ends of polygons in space, and the shares near the search radius and at right angles.

use super::cut::zeros;
use super::gap::foot::Foot;
use super::moving::Moving;
use super::projection::Projection;
use super::search::FootPoint;
use super::stencil::{Against, Kind, Projected, Stencil};
use super::surface::Surface;
use crate::element::Facet;
use crate::tensor::{Matrix, Vector, unit_vector};

/// A linear form in positions and in averaged normals, by scene nodes and by nodes of a surface.
#[derive(Clone, Debug, Default)]
pub(super) struct Weighing<const D: usize> {
    pub nodes: Vec<(usize, Vector<D>)>,
    pub normals: Vec<(usize, Vector<D>)>,
}

/// What the weight of a point varies by, if it fades.
pub(super) fn of_point<const D: usize>(
    stencil: &Stencil<'_, D>,
    foot: &Foot<'_, D>,
    near: impl Iterator<Item = (usize, Matrix<D>)>,
) -> Option<Weighing<D>> {
    if stencil.kind() != Kind::Fading {
        return None;
    }
    let p = stencil.projection();
    let (depth, slope) = foot
        .master
        .surface()
        .rim()
        .depth_and_slope(p.facet, foot.nodes, &p.lambda);
    let by_lambda = slope * (stencil.weight() / depth);
    let by_normals = foot.lambda_by_normals().tr_mul(&by_lambda);
    let normals = foot.nodes.iter().zip(&foot.N);
    Some(Weighing {
        nodes: near
            .map(|(a, lambda)| (a, lambda.tr_mul(&by_lambda)))
            .collect(),
        normals: normals.map(|(&b, N)| (b, by_normals * *N)).collect(),
    })
}

/// The ends of the part of `slave` that is opposite the master, among pieces of cut segments, for positions `x` of all scene nodes: as points
/// without weight, each with what it gains.
pub(super) fn ends<'a, const D: usize>(
    stencils: &[Stencil<'a, D>],
    x: &[Vector<D>],
) -> Vec<(Stencil<'a, D>, Weighing<D>)> {
    let mut found: Vec<(usize, usize, End<'a, D>)> = Vec::new();
    let pieces = stencils
        .iter()
        .filter(|s| D == 2 && s.kind() == Kind::Piece);
    for stencil in pieces.filter(|s| s.projection().by == Projection::AlongNormals) {
        let Against::Surface(master) = stencil.against() else {
            continue;
        };
        let foot = stencil.projection().facet;
        let corners = master.surface().facet(foot)[..D].iter().enumerate();
        let rim = master.surface().rim();
        for (k, &b) in corners.filter(|(_, b)| rim.is_corner(**b)) {
            let (facet, t) = stencil.place();
            let known = found.iter_mut().find(|(f, c, _)| (*f, *c) == (facet, b));
            match known {
                Some((.., end)) => {
                    (end.from, end.to) = (end.from.min(t[1]), end.to.max(t[1]));
                }
                None => found.push((
                    facet,
                    b,
                    End {
                        slave: stencil.slave(),
                        master,
                        foot,
                        k,
                        from: t[1],
                        to: t[1],
                    },
                )),
            }
        }
    }
    let ends = found.into_iter();
    ends.flat_map(|(facet, b, end)| end.weigh(facet, b, x))
        .collect()
}

/// The end of a master with the points of one facet of the slave that are opposite its last facet.
struct End<'a, const D: usize> {
    slave: &'a Surface<D>,
    master: &'a Moving<D>,
    /// The last facet, and its corner that ends.
    foot: usize,
    k: usize,
    /// The least and the largest t of the points.
    from: f64,
    to: f64,
}

impl<'a, const D: usize> End<'a, D> {
    fn weigh(
        &self,
        facet: usize,
        b: usize,
        x: &[Vector<D>],
    ) -> Option<(Stencil<'a, D>, Weighing<D>)> {
        let slave = self.slave;
        let nodes = slave.facet(facet);
        let own: Vec<usize> = nodes.iter().map(|&a| slave.nodes()[a]).collect();
        let segment = Facet::gather(slave.order(), &own, x);
        let (end, n) = (self.master.positions()[b], self.master.normals()[b]);
        // u×n = u·across
        let across = Vector::<D>::from_fn(|i, _| [n[1], -n[0]][i]);
        let at = |t: f64| Vector::<D>::from_fn(|i, _| [1.0 - t, t][i]);
        let beside = [0.0, 0.5, 1.0].map(|t| (segment.point(&at(t)) - end).dot(&across));
        let outside = |t: &f64| (*t >= self.to || *t <= self.from) && 0.0 < *t && *t < 1.0;
        let t = zeros(beside).find(outside)?;
        let lambda = at(t);
        let tangent = segment.tangent(&lambda);
        let speed = (tangent[1] - tangent[0]).dot(&across);
        let gains = if t >= self.to { 1.0 } else { -1.0 };
        let gains = gains * slave.measure(facet, &lambda) / speed;
        let way = segment.point(&lambda) - end;
        let point = Projected {
            number: 0,
            facet,
            lambda,
            weight: 0.0,
            x: segment.point(&lambda),
            projection: FootPoint {
                by: Projection::AlongNormals,
                facet: self.foot,
                lambda: unit_vector(self.k),
                foot: end,
                normal: n,
                distance: way.norm(),
                gap: way.dot(&n),
                off_the_end: false,
            },
            kind: Kind::Piece,
        };
        let stencil = Stencil::new(slave, Against::Surface(self.master), point);
        let shapes = stencil
            .slave_shapes()
            .map(|(a, N)| (a, across * (-gains * N)));
        let mut nodes: Vec<_> = shapes.collect();
        nodes.push((self.master.surface().nodes()[b], across * gains));
        let turned = Vector::from_fn(|i, _| [way[1], -way[0]][i] * gains);
        Some((
            stencil,
            Weighing {
                nodes,
                normals: vec![(b, turned)],
            },
        ))
    }
}
