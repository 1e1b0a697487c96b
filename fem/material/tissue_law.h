#pragma once
// Hyperelastic laws as plain data. Units MPa. hyperelasticity.h evaluates the laws and states their common form. C is
// the right Cauchy-Green tensor, J = det F, and I1 = tr C.

#include "mesh/base/geometry.h"

#include <optional>
#include <string_view>
#include <variant>

namespace retractor::fem {

/// mu/2 (tr C - 3) - mu ln J + lambda/2 (ln J)^2 [Bonet, Wood, Nonlinear continuum mechanics, 1997, eq. 5.28]. This
/// neo-Hookean law linearises to linear elasticity with the same mu and lambda.
struct NeoHookean {
    double mu = 0.0; ///< > 0
    double lambda = 0.0; ///< > -2/3 mu
};

/// c10 (I1 - 3) + c01 (I2 - 3) of the volume-preserving part; mu = 2 (c10 + c01). With c01 = 0 the law is the nearly
/// incompressible neo-Hookean solid.
struct MooneyRivlin {
    double c10 = 0.0, c01 = 0.0; ///< c10 + c01 > 0, c01 >= 0
    double bulk = 0.0; ///< K > 0
};

/// mu/2 (I1 - 3) + sum over both fibre families k1/(2 k2) (exp(k2 e^2) - 1), all of the volume-preserving part, where
/// e = kappa (I1 - 3) + (1 - 3 kappa) (I4 - 1) in stretched fibres (e > 0) and e = 0 otherwise [Gasser, Ogden,
/// Holzapfel 2006, doi 10.1098/rsif.2005.0073]. The law describes arteries, and muscle when both families have the
/// same direction.
struct HolzapfelGasserOgden {
    double mu = 0.0; ///< > 0
    double k1 = 0.0; ///< >= 0
    double k2 = 0.0; ///< > 0, dimensionless
    double dispersion = 0.0; ///< kappa: 0 (all fibres parallel) to 1/3 (equally distributed in all directions)
    double bulk = 0.0; ///< K > 0
};

/// C/2 (exp Q - 1), Q = bf Eff^2 + bt (Ess^2 + Enn^2 + 2 Esn^2) + 2 bfs (Efs^2 + Efn^2), with E the Green-Lagrange
/// strain of the volume-preserving part and f the first fibre direction [Guccione, McCulloch, Waldman 1991, doi
/// 10.1115/1.2894084].
struct Guccione {
    double C = 0.0; ///< > 0
    double bf = 0.0, bt = 0.0, bfs = 0.0; ///< > 0, dimensionless
    double bulk = 0.0; ///< K > 0
};

using Hyperelastic = std::variant<NeoHookean, MooneyRivlin, HolzapfelGasserOgden, Guccione>;

/// Fibre directions at rest, unit vectors. Laws without fibres ignore them; Guccione's law uses the first one.
struct FibreDirections {
    Vec3 first = Vec3::UnitX(), second = Vec3::UnitX();
};

/// Fibres that wind round an axis, as in a vessel or in the muscle round the chest. At each place both families lie
/// in the cylinder round the axis through that place, at the same angle on either side of the circumference [Gasser,
/// Ogden, Holzapfel 2006, doi 10.1098/rsif.2005.0073].
struct FibresAround {
    Vec3 point = Vec3::Zero(); ///< a point on the axis, mm, patient LPS
    Vec3 axis = Vec3::UnitZ(); ///< direction of the axis, any length but zero
    double angle_deg = 0.0; ///< 0 (along the circumference) to 90 (along the axis), degrees
};

/// The law's name: "neo-Hookean", "Mooney-Rivlin", "Holzapfel-Gasser-Ogden" or "Guccione".
std::string_view law_name(const Hyperelastic& law);

/// Whether the energy of the law depends on fibres.
bool has_fibres(const Hyperelastic& law);

/// The hyperelastic law of a material with its fibres. The material's Poisson's ratio holds across the fibres, at
/// small strain.
struct TissueLaw {
    /// hyperelastic_law() sets its bulk modulus from Poisson's ratio of the material; a NeoHookean law is used as it is
    Hyperelastic law;
    FibreDirections fibres {}; ///< fixed directions at rest, patient LPS, used when `around` is empty
    /// directions that wind round an axis, computed at the middle of each element by element_fibres()
    std::optional<FibresAround> around {};
};

} // namespace retractor::fem
