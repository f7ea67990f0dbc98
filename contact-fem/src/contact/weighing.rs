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
//! - Gauss points fade near a rim, in proportion to the [depth](super::rim::Rim::depth) of their feet, as a length where facets of the slave
//!   are not much longer than those of the master.
//!
//! Left out are the ends of polygons in space, and the shares near the search radius, at right angles and out of sight.

use super::cut::zeros;
use super::gap::foot::Foot;
use super::moving::Moving;
use super::projection::Projection;
use super::search::FootPoint;
use super::stencil::{Against, Kind, Projected, Stencil};
use super::surface::Surface;
use crate::element::Facet;
use crate::tensor::{Matrix, Vector, unit_vector};

/// The derivative of a point's weight (UL in the plane, UL² in space): a linear form in positions and in averaged normals.
#[derive(Clone, Debug, Default)]
pub(super) struct Weighing<const D: usize> {
    /// ∂w/∂x_a of scene nodes a (the unit of w divided by UL).
    pub nodes: Vec<(usize, Vector<D>)>,
    /// ∂w/∂n_b of the master's nodes b, which are positions in [`Surface::nodes`] (the unit of w).
    pub normals: Vec<(usize, Vector<D>)>,
}

/// What the weight of a point varies by, if it fades.
pub(super) fn of_point<const D: usize>(
    stencil: &Stencil<'_, D>,
    foot: &Foot<'_, D>,
    near: impl Iterator<Item = (usize, Matrix<D>)>,
) -> Option<Weighing<D>> {
    let Kind::Fading { by_length } = stencil.kind() else {
        return None;
    };
    let p = stencil.projection();
    let rim = foot.master.surface().rim();
    let (value, slope) = match by_length {
        true => rim.length_and_slope(p.facet, foot.nodes, &p.lambda),
        false => rim.depth_and_slope(p.facet, foot.nodes, &p.lambda),
    };
    let by_lambda = slope * (stencil.weight() / value);
    let by_normals = foot.lambda_by_normals().tr_mul(&by_lambda);
    let normals = foot.nodes.iter().zip(&foot.N);
    Some(Weighing {
        nodes: near
            .map(|(a, lambda)| (a, lambda.tr_mul(&by_lambda)))
            .collect(),
        normals: normals.map(|(&b, N)| (b, by_normals * *N)).collect(),
    })
}

/// Where the part of a slave that is opposite the master ends, among the pieces of cut segments, for positions `x` of all scene nodes: points
/// without weight, each with what it gains.
pub(super) fn ends<'a, const D: usize>(
    stencils: &[Stencil<'a, D>],
    x: &[Vector<D>],
) -> Vec<(Stencil<'a, D>, Weighing<D>)> {
    let mut ends: Vec<End<'a, D>> = Vec::new();
    let pieces = stencils
        .iter()
        .filter(|s| D == 2 && s.kind() == Kind::Piece);
    for stencil in pieces.filter(|s| s.projection().by == Projection::AlongNormals) {
        let Against::Surface(master) = stencil.against() else {
            continue;
        };
        let (facet, t) = (stencil.place().0, stencil.place().1[1]);
        let last = stencil.projection().facet;
        let corners = master.surface().facet(last)[..D].iter().enumerate();
        let rim = master.surface().rim();
        for (corner, &node) in corners.filter(|(_, node)| rim.is_corner(**node)) {
            let known = ends
                .iter_mut()
                .find(|end| (end.facet, end.node) == (facet, node));
            match known {
                Some(end) => (end.from, end.to) = (end.from.min(t), end.to.max(t)),
                None => ends.push(End {
                    slave: stencil.slave(),
                    facet,
                    master,
                    node,
                    last,
                    corner,
                    from: t,
                    to: t,
                }),
            }
        }
    }
    ends.iter().filter_map(|end| end.weighing(x)).collect()
}

/// The end of a master opposite a facet of the slave.
struct End<'a, const D: usize> {
    slave: &'a Surface<D>,
    facet: usize,
    master: &'a Moving<D>,
    /// The last node, by its position in [`Surface::nodes`]; the last facet, and the corner of it that the node is.
    node: usize,
    last: usize,
    corner: usize,
    /// The least and the largest t of the slave's points opposite the last facet.
    from: f64,
    to: f64,
}

impl<'a, const D: usize> End<'a, D> {
    /// The point of the slave there, and what it gains; `None` where the slave's facet does not reach so far.
    fn weighing(&self, x: &[Vector<D>]) -> Option<(Stencil<'a, D>, Weighing<D>)> {
        let (slave, facet) = (self.slave, self.facet);
        let own = slave.facet(facet).iter().map(|&a| slave.nodes()[a]);
        let segment = Facet::gather(slave.order(), &own.collect::<Vec<_>>(), x);
        let end = self.master.positions()[self.node];
        let n = self.master.normals()[self.node];
        // u×n = u·across
        let across = Vector::<D>::from_fn(|i, _| [n[1], -n[0]][i]);
        let at = |t: f64| Vector::<D>::from_fn(|i, _| [1.0 - t, t][i]);
        let beside = [0.0, 0.5, 1.0].map(|t| (segment.point(&at(t)) - end).dot(&across));
        let is_end = |t: &f64| (*t >= self.to || *t <= self.from) && 0.0 < *t && *t < 1.0;
        let t = zeros(beside).find(is_end)?;
        let lambda = at(t);
        let tangent = segment.tangent(&lambda);
        let speed = (tangent[1] - tangent[0]).dot(&across);
        let sign = if t >= self.to { 1.0 } else { -1.0 };
        let gains = sign * slave.measure(facet, &lambda) / speed;
        let x = segment.point(&lambda);
        let foot = (self.last, unit_vector(self.corner));
        let point = Projected {
            number: 0,
            facet,
            lambda,
            weight: 0.0,
            x,
            projection: FootPoint {
                by: Projection::AlongNormals,
                ..FootPoint::on(self.master, foot, &x)
            },
            kind: Kind::Piece,
        };
        let stencil = Stencil::new(slave, Against::Surface(self.master), point);
        let shapes = stencil.slave_shapes();
        let mut nodes: Vec<_> = shapes.map(|(a, N)| (a, across * (-gains * N))).collect();
        nodes.push((self.master.surface().nodes()[self.node], across * gains));
        let way = x - end;
        let turned = Vector::from_fn(|i, _| [way[1], -way[0]][i] * gains);
        let normals = vec![(self.node, turned)];
        Some((stencil, Weighing { nodes, normals }))
    }
}
