#pragma once
// Energy and forces of four-node elements of the corotational_linear model (elasticity.h), several elements at a
// time. The results are those of evaluate_point(), but only the rotation nearest to F is computed. Newton's iteration
// for the polar factor, X <- (g X + X^-T / g) / 2 with g from the Frobenius norms, finds the rotation in four to six
// steps [Higham 1986, Computing the polar decomposition - with applications, doi 10.1137/0907079]. Where F inverts
// the element, or where the element is too flat for the iteration to converge, the rotation comes from the singular
// values. Processors with AVX2 and FMA use these instructions; results differ by round-off. Units mm, N, MPa.

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
    /// @param gradients gradients of the shape functions at rest, 1/mm, ordered by element, node, axis.
    /// @param volumes of the elements at rest, mm^3.
    /// @param lame one per element.
    CorotationalElements(const mesh::TetMesh& mesh, const std::vector<double>& gradients,
        const std::vector<double>& volumes, const std::vector<Lame>& lame);

    /// Number of elements in a pack.
    static constexpr std::size_t kPack = 4;
    std::size_t packs() const { return packs_.size(); }
    /// Adds the forces (N) of the elements in packs first_pack to end_pack - 1.
    /// @return the energy of these elements, N mm.
    double add_response(const Eigen::VectorXd& displacement, std::size_t first_pack, std::size_t end_pack,
        Eigen::VectorXd& forces) const;
    std::size_t bytes() const { return packs_.size() * sizeof(Pack); }

    using Lanes = std::array<double, kPack>;
    struct Pack { ///< one lane per element; lanes beyond the last element have zero volume
        std::array<std::array<std::int32_t, kPack>, 4> unknown; ///< first unknown of each node
        /// gradients of nodes 1 to 3 by axis; the gradient of node 0 is minus their sum
        std::array<std::array<Lanes, 3>, 3> gradient;
        Lanes volume, mu, lambda;
    };

private:
    std::vector<Pack> packs_;
};

} // namespace retractor::fem
