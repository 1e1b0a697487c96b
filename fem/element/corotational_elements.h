#pragma once
// Four-node elements of the bounded model (elasticity.h), some at a time: energy and forces as evaluate_point() gives
// them, by the rotation nearest to F alone. That comes from Newton's iteration for the polar factor, X <- (g X + X^-T /
// g) / 2 [Higham 1986, Computing the polar decomposition - with applications, doi 10.1137/0907079], g from the
// Frobenius norms, which takes four to six steps; where F turns the element over, or is so flat that it does not
// converge, from the singular values. On processors with AVX2 and FMA these are used; results differ by round-off.
// Units mm, N, MPa.

#include "fem/material/elasticity.h"
#include "mesh/tetrahedra/tet_mesh.h"

#include <Eigen/Core>

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace retractor::fem {

class CorotationalElements {
public:
    /// @param gradients of the shape functions at rest: element, node, axis. @param volumes of the elements at rest.
    CorotationalElements(const mesh::TetMesh& mesh, const std::vector<double>& gradients,
        const std::vector<double>& volumes, const std::vector<Lame>& lame);

    /// Elements are taken in packs of so many.
    static constexpr std::size_t kPack = 4;
    std::size_t packs() const { return packs_.size(); }
    /// Adds the forces of these packs' elements. @return their energy.
    double add_response(const Eigen::VectorXd& displacement, std::size_t first_pack, std::size_t end_pack,
        Eigen::VectorXd& forces) const;
    std::size_t bytes() const { return packs_.size() * sizeof(Pack); }

    using Lanes = std::array<double, kPack>;
    struct Pack { ///< by lane; those beyond the last element have no volume
        std::array<std::array<std::int32_t, kPack>, 4> unknown; ///< the first of each node
        std::array<std::array<Lanes, 3>, 3> gradient; ///< of the nodes 1 to 3, by axis; node 0 has less their sum
        Lanes volume, mu, lambda;
    };

private:
    std::vector<Pack> packs_;
};

} // namespace retractor::fem
