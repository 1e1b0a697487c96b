#pragma once
// What answering a cut costs without any of the fast ways, for the benches to compare with: all elements assembled into
// a known pattern, then CHOLMOD: analysis (METIS), supernodal factor, solve.

#include "fem/interactive/online_opening.h"
#include "fem/linear_algebra/symmetric_pattern.h"

#include <span>
#include <vector>

namespace retractor::benchmarks {

class FullRebuild {
public:
    /// Makes the pattern, outside all times. @param stiffness of the mesh; hooks hold their nodes at their
    /// displacement. @param blas_threads for the factor alone.
    FullRebuild(fem::OnlineStiffness stiffness, std::span<const VertexId> fixed, std::span<const fem::OnlineHook> hooks,
        int blas_threads);

    void run();
    double assemble_ms = 0.0, analyse_ms = 0.0, factor_ms = 0.0, solve_ms = 0.0;
    double total_ms() const { return assemble_ms + analyse_ms + factor_ms + solve_ms; }

    /// mm, three per vertex id. @pre run()
    const Eigen::VectorXd& solution() const { return solution_; }

private:
    fem::OnlineStiffness stiffness_;
    int blas_threads_; ///< for the factor; all else uses one
    Eigen::VectorXd prescribed_; ///< by vertex id
    std::vector<VertexId> free_;
    std::vector<std::int32_t> number_;
    fem::SymmetricPattern pattern_;
    std::vector<double> values_;
    Eigen::VectorXd solution_;
};

/// Speed of a matrix product of 4096 x 4096, GFlop/s: what the factor's speed is to be judged by.
double full_rebuild_gemm_gflops();

} // namespace retractor::benchmarks
