#include "planner/evidence/association_rules.h"

#include "mesh/base/assert.h"
#include "mesh/base/error.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>
#include <numeric>
#include <utility>

namespace retractor::planner {

namespace {

    constexpr std::size_t kBits = 64;
    constexpr std::size_t kMostRules = 50'000'000; // their p-values take 400 MB
    constexpr int kMostLeft = 8;

    using Holders = std::vector<std::uint64_t>;

    std::size_t count_of(const Holders& holders)
    {
        std::size_t count = 0;
        for (const std::uint64_t word : holders)
            count += static_cast<std::size_t>(std::popcount(word));
        return count;
    }

    std::size_t count_of_both(const Holders& a, const Holders& b)
    {
        std::size_t count = 0;
        for (std::size_t w = 0; w < a.size(); ++w)
            count += static_cast<std::size_t>(std::popcount(a[w] & b[w]));
        return count;
    }

    AssociationRule rule_of(std::vector<std::size_t> left, std::size_t right, std::size_t persons, std::size_t n_left,
        std::size_t n_right, std::size_t n_both)
    {
        AssociationRule rule {
            .left = std::move(left), .right = right, .n_left = n_left, .n_right = n_right, .n_both = n_both
        };
        const auto n = static_cast<double>(persons), l = static_cast<double>(n_left), r = static_cast<double>(n_right),
                   both = static_cast<double>(n_both);
        rule.left_support = l / n;
        rule.right_support = r / n;
        rule.support = both / n;
        rule.confidence = both / l;
        rule.lift = rule.confidence / rule.right_support;
        const double expected = l * r / n, variance = expected * (1.0 - expected / n);
        rule.z = variance > 0.0 ? (both - expected) / std::sqrt(variance) : 0.0;
        rule.p = p_of_both(persons, n_left, n_right, n_both);
        return rule;
    }

    /// A search over left sides, depth first.
    class Search {
    public:
        Search(const ItemTable& table, const RuleThresholds& thresholds, const Job& job)
            : table_(table)
            , thresholds_(thresholds)
            , job_(job)
            // The least number of persons; a share on the limit counts, whatever rounding makes of it.
            , least_(static_cast<std::size_t>(
                  std::ceil(thresholds.support * static_cast<double>(table.persons) * (1.0 - 1e-12))))
        {
            for (std::size_t i = 0; i < table.items.size(); ++i) {
                counts_.push_back(count_of(table.items[i].holders));
                const bool enough = counts_.back() >= std::max<std::size_t>(least_, 1);
                if (enough && table.items[i].left)
                    lefts_.push_back(i);
                if (enough && table.items[i].right)
                    rights_.push_back(i);
            }
        }

        FoundRules run()
        {
            for (std::size_t n = 0; n < lefts_.size() && !job_.cancelled(); ++n) {
                job_.report("rules", static_cast<double>(n) / static_cast<double>(lefts_.size()));
                extend({ lefts_[n] }, table_.items[lefts_[n]].holders, counts_[lefts_[n]], n + 1);
            }
            const std::vector<double> adjusted = adjusted_p_values(p_);
            for (std::size_t n = 0; n < found_.rules.size(); ++n)
                found_.rules[n].p_adjusted = adjusted[at_[n]];
            found_.tested = p_.size();
            std::ranges::stable_sort(
                found_.rules, [](const AssociationRule& a, const AssociationRule& b) { return a.lift > b.lift; });
            return std::move(found_);
        }

    private:
        void extend(const std::vector<std::size_t>& left, const Holders& holders, std::size_t count, std::size_t next)
        {
            for (const std::size_t right : rights_)
                if (std::ranges::find(left, right) == left.end())
                    test(left, right, count, count_of_both(holders, table_.items[right].holders));
            if (static_cast<int>(left.size()) >= thresholds_.most_left)
                return;
            Holders both(holders.size());
            for (std::size_t n = next; n < lefts_.size() && !job_.cancelled(); ++n) {
                const Holders& other = table_.items[lefts_[n]].holders;
                for (std::size_t w = 0; w < both.size(); ++w)
                    both[w] = holders[w] & other[w];
                const std::size_t held = count_of(both);
                if (held < std::max<std::size_t>(least_, 1))
                    continue;
                std::vector<std::size_t> longer = left;
                longer.push_back(lefts_[n]);
                extend(longer, both, held, n + 1);
            }
        }

        void test(const std::vector<std::size_t>& left, std::size_t right, std::size_t n_left, std::size_t n_both)
        {
            AssociationRule rule = rule_of(left, right, table_.persons, n_left, counts_[right], n_both);
            if (p_.size() >= kMostRules)
                throw InputError("there are more than 50 million rules to test: ask for more support, or fewer "
                                 "items on the left side",
                    "support", { "support", "most_left" });
            p_.push_back(rule.p);
            constexpr double kRounding = 1e-12; // relative; a number on the limit passes
            if (n_both >= least_ && n_both > 0 && rule.confidence >= thresholds_.confidence * (1.0 - kRounding)
                && rule.lift >= thresholds_.lift * (1.0 - kRounding)) {
                at_.push_back(p_.size() - 1);
                found_.rules.push_back(std::move(rule));
            }
        }

        const ItemTable& table_;
        const RuleThresholds& thresholds_;
        const Job& job_;
        std::size_t least_;
        std::vector<std::size_t> counts_, lefts_, rights_;
        std::vector<double> p_; ///< of all rules that were tested
        std::vector<std::size_t> at_; ///< places of the found rules among them
        FoundRules found_;
    };

} // namespace

std::size_t words_for(std::size_t persons) { return (persons + kBits - 1) / kBits; }

FoundRules find_rules(const ItemTable& table, const RuleThresholds& thresholds, const Job& job)
{
    const auto check = [](bool right, const char* what, const char* field) {
        if (!right)
            throw InputError(what, field, { field });
    };
    check(table.persons > 0, "there is no person", "persons");
    check(thresholds.support >= 0.0 && thresholds.support <= 1.0, "the support is a share, 0 to 1", "support");
    check(thresholds.confidence >= 0.0 && thresholds.confidence <= 1.0, "the confidence is a share, 0 to 1",
        "confidence");
    check(thresholds.lift >= 0.0 && std::isfinite(thresholds.lift), "the lift is at least 0", "lift");
    check(
        thresholds.most_left >= 1 && thresholds.most_left <= kMostLeft, "the left side has 1 to 8 items", "most_left");
    for (const Item& item : table.items)
        RETRACTOR_ASSERT(item.holders.size() == words_for(table.persons));
    return Search(table, thresholds, job).run();
}

double p_of_both(std::size_t persons, std::size_t n_left, std::size_t n_right, std::size_t n_both)
{
    RETRACTOR_ASSERT(n_both <= n_left && n_both <= n_right && n_left <= persons && n_right <= persons);
    const auto n = static_cast<double>(persons), l = static_cast<double>(n_left), r = static_cast<double>(n_right);
    if (std::min(n_left, n_right) > kExactUpTo) {
        const double variance = l * r * (n - l) * (n - r) / (n * n * (n - 1.0));
        return variance > 0.0 ? std::erfc(std::abs(static_cast<double>(n_both) - l * r / n) / std::sqrt(2.0 * variance))
                              : 1.0;
    }
    // log C(n, k)
    const auto choose = [](double all, double some) {
        return std::lgamma(all + 1.0) - std::lgamma(some + 1.0) - std::lgamma(all - some + 1.0);
    };
    const auto log_chance = [&](double both) { return choose(l, both) + choose(n - l, r - both) - choose(n, r); };
    constexpr double kEqual = 1e-7; // splits that are as likely but for rounding
    const double found = log_chance(static_cast<double>(n_both)) + kEqual;
    double p = 0.0;
    for (double both = std::max(0.0, l + r - n); both <= std::min(l, r); both += 1.0)
        if (const double chance = log_chance(both); chance <= found)
            p += std::exp(chance);
    return std::min(p, 1.0);
}

std::vector<double> adjusted_p_values(const std::vector<double>& p)
{
    std::vector<std::size_t> order(p.size());
    std::iota(order.begin(), order.end(), std::size_t { 0 });
    std::ranges::sort(order, [&](std::size_t a, std::size_t b) { return p[a] < p[b]; });
    std::vector<double> adjusted(p.size());
    double least = 1.0;
    for (std::size_t n = order.size(); n-- > 0;) {
        least = std::min(least, p[order[n]] * static_cast<double>(p.size()) / static_cast<double>(n + 1));
        adjusted[order[n]] = least;
    }
    return adjusted;
}

} // namespace retractor::planner
