#pragma once
// Dense matrices of some thousand rows by BLAS and LAPACK (OpenBLAS), which are faster than the kernels of Eigen at
// this size.

#include <Eigen/Core>

#include <cstdint>
#include <string>
#include <vector>

namespace retractor::fem {

/// The number of cores that one call may use. The result has the same bits with one core and with two.
enum class Cores { one, two };

Eigen::MatrixXd product(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b); ///< a b
Eigen::MatrixXd product_transposed(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b); ///< a^T b
Eigen::MatrixXd times_own_transpose(const Eigen::MatrixXd& lower); ///< L L^T. @pre all entries above the diagonal are 0

/// Copies the lower triangle of from(rows, rows). Runs of consecutive rows are copied at once, so `rows` should mostly
/// rise.
void copy_lower(const Eigen::MatrixXd& from, const std::vector<std::int32_t>& rows, Eigen::Ref<Eigen::MatrixXd> to);

/// a -= b c^T, computed in the lower triangle only; mirror_lower() completes the upper triangle.
/// @pre b c^T is symmetric
void subtract_lower_product(Eigen::Ref<Eigen::MatrixXd> a, const Eigen::Ref<const Eigen::MatrixXd>& b,
    const Eigen::Ref<const Eigen::MatrixXd>& c, Cores cores = Cores::one);
void mirror_lower(Eigen::MatrixXd& a); ///< copies the lower triangle onto the upper

/// Replaces a lower triangular Cholesky factor L by the inverse of L L^T, both triangles.
void invert_from_factor(Eigen::MatrixXd& L);

/// Replaces the lower triangle by the Cholesky factor. A large matrix uses two cores, with the same bits as one core.
/// The diagonal blocks of the upper triangle are overwritten.
/// @return false when the matrix is not positive definite
[[nodiscard]] bool cholesky(Eigen::MatrixXd& a);
/// Factors a block of a larger matrix, on one core.
/// @param stride number of rows of the larger matrix
/// @return the column at which the block is not positive definite, or -1
[[nodiscard]] Eigen::Index factor_block(double* a, Eigen::Index columns, Eigen::Index stride);
/// Solves in place with the lower triangle L (forward) or with its transpose (backward).
void forward(const Eigen::MatrixXd& L, Eigen::MatrixXd& b);
void backward(const Eigen::MatrixXd& L, Eigen::MatrixXd& b);
/// b L^-T, in place. Only the lower triangle of L is read.
void divide_by_transpose(
    const Eigen::Ref<const Eigen::MatrixXd>& L, Eigen::Ref<Eigen::MatrixXd> b, Cores cores = Cores::one);
/// The column that divides the area of a lower triangle of n columns into halves.
Eigen::Index half_of_lower(Eigen::Index n);

/// Replaces a symmetric positive definite matrix by its inverse.
/// @throws SolverError naming `what` when the matrix is not positive definite
void invert_positive_definite(Eigen::MatrixXd& a, const std::string& what);

/// Eigenvalues and eigenvectors of a symmetric matrix V diag(values) V^T.
struct SymmetricModes {
    Eigen::VectorXd values; ///< rising
    Eigen::MatrixXd vectors; ///< orthonormal columns
};

/// Computes the eigenvalues and eigenvectors from the lower triangle.
/// @throws InputError when the matrix is not square, SolverError when any entry is NaN or infinite
SymmetricModes symmetric_modes(Eigen::MatrixXd a);

/// LU factorisation of a general square matrix, with row exchanges.
class DenseLu {
public:
    explicit DenseLu(Eigen::MatrixXd a);
    void solve(Eigen::MatrixXd& b) const; ///< in place
    double reciprocal_condition() const { return rcond_; } ///< estimate in the 1-norm; 0 when singular

private:
    Eigen::MatrixXd lu_;
    std::vector<int> exchanges_;
    double rcond_ = 0.0;
};

} // namespace retractor::fem
