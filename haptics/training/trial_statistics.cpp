#include "haptics/training/trial_statistics.h"

#include "mesh/base/error.h"

#include <boost/math/distributions/fisher_f.hpp>
#include <boost/math/distributions/students_t.hpp>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>

namespace retractor::haptics {

namespace {

    void check(std::span<const double> values, std::size_t least)
    {
        if (values.size() < least)
            throw InputError("a sample of " + std::to_string(values.size()) + " is too small: " + std::to_string(least)
                + " values are needed");
        if (!std::all_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); }))
            throw InputError("a sample holds a value that is not finite");
    }

    double mean(std::span<const double> values)
    {
        return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
    }

    double variance(std::span<const double> values)
    {
        const double middle = mean(values);
        double sum = 0.0;
        for (const double v : values)
            sum += (v - middle) * (v - middle);
        return sum / static_cast<double>(values.size() - 1);
    }

    double two_sided(double t, double freedom)
    {
        const boost::math::students_t distribution(freedom);
        return 2.0 * boost::math::cdf(boost::math::complement(distribution, std::abs(t)));
    }

} // namespace

BoxNumbers box_numbers(std::span<const double> values)
{
    check(values, 1);
    std::vector<double> sorted(values.begin(), values.end());
    std::sort(sorted.begin(), sorted.end());
    const auto at = [&](double share) {
        const double place = share * static_cast<double>(sorted.size() - 1);
        const auto below = static_cast<std::size_t>(place);
        const std::size_t above = std::min(below + 1, sorted.size() - 1);
        return sorted[below] + (place - static_cast<double>(below)) * (sorted[above] - sorted[below]);
    };
    return { sorted.front(), at(0.25), at(0.5), at(0.75), sorted.back(), sorted.size() };
}

FTest f_test(std::span<const double> a, std::span<const double> b)
{
    check(a, 2);
    check(b, 2);
    const double va = variance(a), vb = variance(b);
    if (!(va > 0.0) || !(vb > 0.0))
        throw InputError("an F-test needs samples that vary");
    FTest test {
        .F = va / vb, .freedom_a = static_cast<int>(a.size()) - 1, .freedom_b = static_cast<int>(b.size()) - 1
    };
    const boost::math::fisher_f distribution(test.freedom_a, test.freedom_b);
    const double below = boost::math::cdf(distribution, test.F);
    const double above = boost::math::cdf(boost::math::complement(distribution, test.F));
    test.p = std::min(1.0, 2.0 * std::min(below, above));
    return test;
}

TTest paired_t_test(std::span<const double> a, std::span<const double> b)
{
    if (a.size() != b.size())
        throw InputError("a paired t-test needs two values of each person, got " + std::to_string(a.size()) + " and "
            + std::to_string(b.size()));
    check(a, 2);
    check(b, 2);
    std::vector<double> differences(a.size());
    for (std::size_t i = 0; i < a.size(); ++i)
        differences[i] = a[i] - b[i];
    const double v = variance(differences);
    if (!(v > 0.0))
        throw InputError("a paired t-test needs differences that vary");
    TTest test;
    test.difference = mean(differences);
    test.freedom = static_cast<double>(a.size() - 1);
    test.t = test.difference / std::sqrt(v / static_cast<double>(a.size()));
    test.p = two_sided(test.t, test.freedom);
    return test;
}

} // namespace retractor::haptics
