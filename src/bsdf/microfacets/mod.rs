//! Integrals over the visible microfacets of a GGX lobe, by quadrature, with any factor of the angle at the facet.
//!
//! Sources: visible normals of Heitz, "Sampling the GGX Distribution of Visible Normals", 2018: scaled by α the surface is a
//! hemisphere, whose visible normals N are uniform across the view. Nodes and weights: Gauss–Legendre (Press et al., "Numerical
//! Recipes", 3rd edition, section 4.6).
//!
//! The integral is bounded by quadratic forms of N: reflected light along the surface, and the critical angle of total reflection at
//! the facet. Both regions contain N = o/α, whose facet faces the viewer. The region is cut into arcs from pole to pole of an axis
//! across the plane of that N and the normal. So its border is exact on each arc, and the integrand has no kink inside.

mod arc_points;
mod integral;
mod lobe;
mod region;

pub(super) use lobe::Microfacets;
