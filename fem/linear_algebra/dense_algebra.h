#pragma once
// Dense matrices of some thousand rows by BLAS and LAPACK (OpenBLAS), which Eigen's own kernels cannot follow here.

#include <Eigen/Core>

#include <cstdint>
#include <string>
#include <vector>

namespace retractor::fem {

/// How many cores one call may use; the bits are the same.
enum class Cores { one, two };

Eigen::MatrixXd product(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b); ///< a b
Eigen::MatrixXd product_transposed(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b); ///< a^T b
Eigen::MatrixXd times_own_transpose(const Eigen::MatrixXd& lower); ///< L L^T; what is above L's diagonal must be 0

/// The lower triangle of from(rows, rows); rows rising for the most part.
void copy_lower(const Eigen::MatrixXd& from, const std::vector<std::int32_t>& rows, Eigen::Ref<Eigen::MatrixXd> to);

/// a -= b c^T, where that product is symmetric: half of it is computed.
/// The upper triangle is left as it is: see mirror_lower().
void subtract_lower_product(
    Eigen::Ref<Eigen::MatrixXd> a, const Eigen::MatrixXd& b, const Eigen::MatrixXd& c, Cores cores = Cores::one);
void mirror_lower(Eigen::MatrixXd& a); ///< copies the lower triangle onto the upper

/// Replaces a lower triangular Cholesky factor L by the whole inverse of L L^T.
void invert_from_factor(Eigen::MatrixXd& L);

/// Replaces the lower triangle by the Cholesky factor, that of a large matrix on two cores, with the same bits on one.
/// The upper triangle's diagonal blocks are not kept. @return false when the matrix is not positive definite.
[[nodiscard]] bool cholesky(Eigen::MatrixXd& a);
/// The same for a block of a larger matrix, on one core. @param stride rows of that matrix.
/// @return the column at which the block is not positive definite; -1: none.
[[nodiscard]] Eigen::Index factor_block(double* a, Eigen::Index columns, Eigen::Index stride);
/// Solves with the lower triangle L alone (forward) or its transpose (backward), in place.
void forward(const Eigen::MatrixXd& L, Eigen::MatrixXd& b);
void backward(const Eigen::MatrixXd& L, Eigen::MatrixXd& b);
void divide_by_transpose(const Eigen::MatrixXd& L, Eigen::MatrixXd& b, Cores cores = Cores::one); ///< b L^-T, in place

/// Replaces a symmetric positive definite matrix by its inverse. @throws SolverError naming `what` when it is not.
void invert_positive_definite(Eigen::MatrixXd& a, const std::string& what);

/// A symmetric matrix as V diag(values) V^T.
struct SymmetricModes {
    Eigen::VectorXd values; ///< rising
    Eigen::MatrixXd vectors; ///< orthonormal columns
};

/// Only the lower triangle counts. @throws InputError when the matrix is not square, SolverError when it holds NaN or
/// infinity anywhere.
SymmetricModes symmetric_modes(Eigen::MatrixXd a);

/// LU with row exchanges, of a general square matrix.
class DenseLu {
public:
    explicit DenseLu(Eigen::MatrixXd a);
    void solve(Eigen::MatrixXd& b) const; ///< in place
    double reciprocal_condition() const { return rcond_; } ///< estimate in the 1-norm; 0: singular

private:
    Eigen::MatrixXd lu_;
    std::vector<int> exchanges_;
    double rcond_ = 0.0;
};

} // namespace retractor::fem
