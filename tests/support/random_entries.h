#pragma once
// Matrices of random entries between -1 and 1. A seed gives the same matrix on every run.

#include <Eigen/Core>

#include <random>

namespace retractor::test_support {

inline Eigen::MatrixXd random_entries(Eigen::Index rows, Eigen::Index columns, unsigned seed)
{
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> entry(-1.0, 1.0);
    return Eigen::MatrixXd::NullaryExpr(rows, columns, [&] { return entry(random); });
}

} // namespace retractor::test_support
