#include "planner/uncertainty/stiffness_samples.h"

#include "mesh/base/assert.h"
#include "mesh/base/error.h"
#include "mesh/base/statistics.h"
#include "planner/plan/parameter_interval.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

namespace retractor::planner {

namespace {

    /// The approaches by falling score; of equal scores the first comes first.
    std::vector<std::size_t> order_of(std::span<const std::optional<double>> scores)
    {
        std::vector<std::size_t> order(scores.size());
        std::iota(order.begin(), order.end(), std::size_t { 0 });
        std::ranges::stable_sort(order, [&](std::size_t a, std::size_t b) { return *scores[a] > *scores[b]; });
        return order;
    }

    bool all_known(std::span<const std::optional<double>> scores)
    {
        return std::ranges::all_of(scores, [](const std::optional<double>& score) { return score.has_value(); });
    }

} // namespace

std::vector<StiffnessFactors> sample_stiffness(const Case& planned_case, int samples, unsigned seed)
{
    if (samples < 1)
        throw InputError("at least one sample is needed", "samples");
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> within(0.0, 1.0);
    std::vector<StiffnessFactors> all(static_cast<std::size_t>(samples));
    std::vector<int> part(all.size());
    for (const std::string& name : stiffness_names(planned_case)) {
        const PublishedRange range = published_range(name);
        const double half = 0.5 * std::log(range.high / range.low);
        std::iota(part.begin(), part.end(), 0);
        std::ranges::shuffle(part, random);
        for (std::size_t n = 0; n < all.size(); ++n) {
            const double at = (part[n] + within(random)) / samples; // 0 to 1
            all[n][name] = std::exp(half * (2.0 * at - 1.0));
        }
    }
    return all;
}

std::optional<Spread> spread_of(std::vector<double> values)
{
    if (values.empty())
        return std::nullopt;
    constexpr double kLow = 0.05, kHigh = 0.95;
    const auto rank = [&](double share) {
        return static_cast<std::size_t>(std::lround(share * static_cast<double>(values.size() - 1)));
    };
    return Spread { .median = upper_median(values),
        .low = value_of_rank(values, rank(kLow)),
        .high = value_of_rank(values, rank(kHigh)),
        .count = values.size() };
}

Survival survival_of(
    std::span<const std::optional<double>> reference, std::span<const std::vector<std::optional<double>>> samples)
{
    Survival survival;
    if (reference.empty() || !all_known(reference))
        return survival;
    const std::vector<std::size_t> own = order_of(reference);
    for (const std::vector<std::optional<double>>& scores : samples) {
        RETRACTOR_ASSERT(scores.size() == reference.size());
        if (!all_known(scores))
            continue;
        const std::vector<std::size_t> order = order_of(scores);
        ++survival.samples;
        survival.same_leader += order.front() == own.front() ? 1 : 0;
        survival.same_order += order == own ? 1 : 0;
    }
    return survival;
}

} // namespace retractor::planner
