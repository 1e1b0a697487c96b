#pragma once
// Factors the first unknowns of a symmetric matrix, or all, and condenses them onto the last unknowns. CHOLMOD would
// also factor the last unknowns, which costs more than all the rest where they are many, and would use one core. Only
// sparse_cholesky.cpp uses this header.

#include "fem/linear_algebra/supernodes.h"
#include "fem/linear_algebra/symmetric_pattern.h"

#include <Eigen/Core>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <vector>

namespace retractor::fem {

/// The lower triangle of an n x n matrix, stored by columns of n rows. What lies above the diagonal has no meaning.
struct FrontUpdate {
    std::unique_ptr<double[]> values;
    std::size_t capacity = 0;
    Eigen::Index n = 0;
    Eigen::Map<Eigen::MatrixXd> matrix() { return { values.get(), n, n }; }
    const double* column(Eigen::Index j) const { return values.get() + j * n; }
};

/// Memory of updates that are no longer needed, for later updates and for the next factorisation: fresh memory costs as
/// much time as the arithmetic. May be used by two threads at the same time.
class UpdateMemory {
public:
    /// An update of zeros, in the smallest free memory that holds it. Where none does, the largest is given up.
    FrontUpdate zeros(Eigen::Index n);
    void give_back(FrontUpdate update);
    std::size_t bytes() const; ///< of the free memory
    void release();

private:
    mutable std::mutex mutex_;
    std::vector<FrontUpdate> free_; ///< by rising capacity
};

struct PartialFactor {
    Eigen::MatrixXd trailing; ///< lower triangle: the term that the condensed first unknowns add among the last
    /// Position in the order of elimination at which the matrix is not positive definite; -1: none.
    Eigen::Index stopped_at = -1;
};
/// Multifrontal Cholesky factorisation (Duff, Reid 1983, doi 10.1145/356044.356047). Two halves of the tree use two
/// cores, and so do the large fronts above them, with the same bits as one core. Entries of the matrix among the last
/// unknowns are not read.
/// @param f the analysed factor
/// @param x values of the factor; the function writes the columns before `end`
/// @param place position in the order of elimination, per unknown
/// @param memory receives the memory that the factorisation took, about half of the factor's
PartialFactor factor_before(const Supernodes& f, double* x, Eigen::Index end, const SymmetricPattern& pattern,
    const std::vector<std::int32_t>& place, const std::vector<double>& values, UpdateMemory& memory);

} // namespace retractor::fem
