#pragma once
// The cost of a new solution after a cut without any reuse, as a baseline for the benchmarks: all elements are
// assembled into a known pattern; CHOLMOD then makes analysis (METIS), supernodal factor and solution.

#include "fem/interactive/online_opening.h"
#include "fem/linear_algebra/symmetric_pattern.h"

#include <span>
#include <vector>

namespace retractor::benchmarks {

class FullRebuild {
public:
    /// Makes the pattern, which no time includes.
    /// @param stiffness of the mesh; hooks prescribe the displacement of their nodes.
    /// @param blas_threads for the factor alone.
    FullRebuild(fem::OnlineStiffness stiffness, std::span<const VertexId> fixed, std::span<const fem::OnlineHook> hooks,
        int blas_threads);

    void run();
    double assemble_ms = 0.0, analyse_ms = 0.0, factor_ms = 0.0, solve_ms = 0.0;
    double total_ms() const { return assemble_ms + analyse_ms + factor_ms + solve_ms; }

    /// Displacement, mm, three per vertex id.
    /// @pre run()
    const Eigen::VectorXd& solution() const { return solution_; }

private:
    fem::OnlineStiffness stiffness_;
    int blas_threads_; ///< threads of the factor; everything else uses one
    Eigen::VectorXd prescribed_; ///< prescribed displacement by vertex id, mm
    std::vector<VertexId> free_;
    std::vector<std::int32_t> number_;
    fem::SymmetricPattern pattern_;
    std::vector<double> values_;
    Eigen::VectorXd solution_;
};

/// Speed of a matrix product of 4096 x 4096, GFlop/s, as a reference for the speed of the factor.
double full_rebuild_gemm_gflops();

} // namespace retractor::benchmarks
