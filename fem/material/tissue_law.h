#pragma once
// Hyperelastic laws as plain data. Units MPa. hyperelasticity.h evaluates them and says what they have in common.

#include "mesh/base/geometry.h"

#include <optional>
#include <string_view>
#include <variant>

namespace retractor::fem {

/// mu/2 (tr C - 3) - mu ln J + lambda/2 (ln J)^2 [Bonet, Wood, Nonlinear continuum mechanics, 1997, eq. 5.28], the one
/// whose linearisation is linear elasticity with these parameters.
struct NeoHookean {
    double mu = 0.0; ///< > 0
    double lambda = 0.0; ///< > -2/3 mu
};

/// c10 (I1 - 3) + c01 (I2 - 3) of the volume-keeping part; mu = 2 (c10 + c01). With c01 = 0: the incompressible
/// neo-Hookean solid.
struct MooneyRivlin {
    double c10 = 0.0, c01 = 0.0; ///< c10 + c01 > 0, c01 >= 0
    double bulk = 0.0; ///< K > 0
};

/// mu/2 (I1 - 3) + sum over both fibre families k1/(2 k2) (exp(k2 e^2) - 1), e = kappa (I1 - 3) + (1 - 3 kappa) (I4 -
/// 1) where fibres are stretched (e > 0), else 0, of the volume-keeping part [Gasser, Ogden, Holzapfel 2006, doi
/// 10.1098/rsif.2005.0073]: arteries, and muscle with both families alike.
struct HolzapfelGasserOgden {
    double mu = 0.0; ///< > 0
    double k1 = 0.0; ///< >= 0
    double k2 = 0.0; ///< > 0, without unit
    double dispersion = 0.0; ///< kappa: 0 (all fibres along their direction) to 1/3 (in all directions alike)
    double bulk = 0.0; ///< K > 0
};

/// C/2 (exp Q - 1), Q = bf Eff^2 + bt (Ess^2 + Enn^2 + 2 Esn^2) + 2 bfs (Efs^2 + Efn^2), with the Green-Lagrange
/// strain of the volume-keeping part [Guccione, McCulloch, Waldman 1991, doi 10.1115/1.2894084]; fibres along the first
/// direction.
struct Guccione {
    double C = 0.0; ///< > 0
    double bf = 0.0, bt = 0.0, bfs = 0.0; ///< > 0, without unit
    double bulk = 0.0; ///< K > 0
};

using Hyperelastic = std::variant<NeoHookean, MooneyRivlin, HolzapfelGasserOgden, Guccione>;

/// Fibre directions at rest; unit vectors. Laws without fibres ignore them, Guccione's takes the first one.
struct FibreDirections {
    Vec3 first = Vec3::UnitX(), second = Vec3::UnitX();
};

/// Fibres that wind round an axis: a vessel's, or muscle's round the chest. Both families lie in the surface of the
/// cylinder through the place, at this angle on both sides of its circumference [Gasser, Ogden, Holzapfel 2006].
struct FibresAround {
    Vec3 point = Vec3::Zero(); ///< on the axis, mm, patient LPS
    Vec3 axis = Vec3::UnitZ(); ///< of any length but zero
    double angle_deg = 0.0; ///< 0 (round the axis) to 90 (along it)
};

/// "neo-Hookean", "Mooney-Rivlin", "Holzapfel-Gasser-Ogden", "Guccione".
std::string_view law_name(const Hyperelastic& law);

/// Whether fibres play a part in it.
bool has_fibres(const Hyperelastic& law);

/// What a material is as hyperelastic tissue. Its Poisson's ratio holds across the fibres, at small strain.
struct TissueLaw {
    Hyperelastic law; ///< its bulk modulus (neo-Hookean: both parameters) comes from the material: hyperelastic_law()
    FibreDirections fibres {}; ///< at rest, the same everywhere in this material, patient LPS; or
    std::optional<FibresAround> around {}; ///< in each element those at its middle: element_fibres()
};

} // namespace retractor::fem
