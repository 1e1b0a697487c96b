#pragma once
// Identifies and measures the linear algebra libraries on this machine.

#include <string>

namespace retractor::ui::cli {

struct BlasCheck {
    std::string library; ///< file to which the dynamic linker bound dgemm
    std::string description; ///< see blas_description()
    bool is_openblas = false; ///< dgemm comes from the OpenBLAS with which this program was linked
    double gflops = 0.0; ///< measured with one thread on a product of 512 x 512 matrices
};
BlasCheck check_blas();

struct SolverCheck {
    std::string cholmod_version;
    int unknowns = 0;
    double seconds = 0.0; ///< assembly, ordering, factorisation and solution
    double relative_error = 0.0; ///< relative error of the force that stretches a bar, against E A u / L
};
/// Stretches a bar of 6,000 tetrahedra. @throws SolverError when the factorisation fails
SolverCheck check_solver();

} // namespace retractor::ui::cli
