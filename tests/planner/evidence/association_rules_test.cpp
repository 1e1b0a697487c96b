#include "planner/evidence/association_rules.h"

#include "mesh/base/error.h"
#include "planner/evidence/person_items.h"
#include "planner/evidence/record_generator.h"
#include "tests/support/test_help.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <random>
#include <string>
#include <vector>

namespace retractor::planner {
namespace association_rules_test {

    namespace fs = std::filesystem;

    /// A row of the published table.
    struct Published {
        const char* left;
        const char* right;
        double left_support, right_support, support, confidence, lift, z;
    };
    constexpr Published kTable[] = {
        { "High_High_High", "past history of pigmentation", 0.0866, 0.4514, 0.0551, 0.6364, 1.4098, 1.6133 },
        { "High_High_High", "past history of acneiform eruptions", 0.0866, 0.6063, 0.0656, 0.7577, 1.2496, 1.1471 },
        { "High_High_Low", "past history of pigmentation", 0.0236, 0.4514, 0.0236, 1.0, 2.2151, 2.4624 },
        { "High_High_Low", "past history of acneiform eruptions", 0.0236, 0.6063, 0.0236, 1.0, 1.6494, 1.5278 },
        { "High_High_Low", "arthralgia", 0.0236, 0.6378, 0.0184, 0.7777, 1.2194, 0.5296 },
        { "Low_High_Low", "abdominal pain", 0.0577, 0.3097, 0.0289, 0.5, 1.6144, 1.6183 },
        { "Low_High_Low", "arthralgia", 0.0577, 0.6378, 0.0472, 0.8182, 1.2828, 1.0793 },
        { "Low_High_Low", "constipation", 0.0577, 0.3858, 0.0289, 0.5, 1.2959, 0.8719 },
        { "Low_High_Low", "cough", 0.0577, 0.4121, 0.0289, 0.5, 1.2134, 0.6503 },
        { "Low_Low_High", "abdominal pain", 0.0210, 0.3097, 0.0131, 0.6248, 2.0172, 1.6066 },
        { "Low_Low_High", "general fatigue", 0.0210, 0.6509, 0.0210, 1.0, 1.5363, 1.2323 },
        { "Low_Low_High", "headache", 0.0210, 0.5722, 0.0158, 0.75, 1.3108, 0.6690 },
        { "Low_Low_Low", "diarrhea", 0.0551, 0.3255, 0.0315, 0.5715, 1.7559, 1.9942 },
    };
    // The published numbers are rounded to four digits, and confidence and z were computed from rounded ones.
    constexpr double kSupport = 1e-4, kConfidence = 2e-4, kLift = 1e-3, kZ = 2e-3;

    PersonItems items_of(const fs::path& file, std::vector<std::string> exposures, bool separate = false)
    {
        return read_person_items(file, { .exposures = std::move(exposures), .separate = separate });
    }

    TEST(AssociationRules, AreThePublishedThirteenWhateverTheSeed)
    {
        for (const unsigned seed : { 1U, 2U, 3U, 4U }) {
            const fs::path file = fs::path(testing::TempDir()) / "exposures.csv";
            write_exposure_records(file, seed);
            const PersonItems items = items_of(file, { "A", "B", "C" });
            EXPECT_EQ(items.records, 795U);
            EXPECT_EQ(items.table.persons, 381U);
            const FoundRules found = find_rules(items.table, {});
            ASSERT_EQ(found.rules.size(), std::size(kTable));
            for (const Published& row : kTable) {
                const auto rule = std::ranges::find_if(found.rules, [&](const AssociationRule& one) {
                    return items.table.items[one.left.at(0)].name == std::string("A_B_C (") + row.left + ")"
                        && items.table.items[one.right].name == row.right;
                });
                ASSERT_NE(rule, found.rules.end()) << row.left << ", " << row.right;
                EXPECT_NEAR(rule->left_support, row.left_support, kSupport);
                EXPECT_NEAR(rule->right_support, row.right_support, kSupport);
                EXPECT_NEAR(rule->support, row.support, kSupport);
                EXPECT_NEAR(rule->confidence, row.confidence, kConfidence);
                EXPECT_NEAR(rule->lift, row.lift, kLift);
                EXPECT_NEAR(rule->z, row.z, kZ);
                EXPECT_GE(rule->p_adjusted, rule->p);
            }
        }
    }

    ItemTable random_table(std::size_t persons, std::size_t items, unsigned seed)
    {
        std::mt19937 random(seed);
        ItemTable table { .persons = persons, .items = {} };
        for (std::size_t i = 0; i < items; ++i) {
            table.items.push_back({ .name = std::to_string(i),
                .left = true,
                .right = true,
                .holders = std::vector<std::uint64_t>(words_for(persons), 0) });
            for (std::size_t person = 0; person < persons; ++person)
                if (random() % 5 < 2)
                    table.items[i].holders[person / 64] |= std::uint64_t { 1 } << (person % 64);
        }
        return table;
    }

    TEST(AssociationRules, AreThoseThatCountingOnePersonAfterTheOtherFinds)
    {
        const ItemTable table = random_table(203, 9, 7);
        const RuleThresholds thresholds { .support = 0.05, .confidence = 0.45, .lift = 1.05, .most_left = 3 };
        const auto holds = [&](std::size_t item, std::size_t person) {
            return (table.items[item].holders[person / 64] >> (person % 64) & 1) != 0;
        };
        std::size_t expected = 0;
        for (unsigned set = 1; set < 1U << table.items.size(); ++set) {
            if (std::popcount(set) > thresholds.most_left)
                continue;
            for (std::size_t right = 0; right < table.items.size(); ++right) {
                if ((set >> right & 1) != 0)
                    continue;
                double n_left = 0, n_right = 0, n_both = 0;
                for (std::size_t person = 0; person < table.persons; ++person) {
                    bool all = true;
                    for (std::size_t item = 0; item < table.items.size(); ++item)
                        all = all && ((set >> item & 1) == 0 || holds(item, person));
                    n_left += all ? 1 : 0;
                    n_right += holds(right, person) ? 1 : 0;
                    n_both += all && holds(right, person) ? 1 : 0;
                }
                const auto n = static_cast<double>(table.persons);
                expected += n_left > 0 && n_both / n >= thresholds.support && n_both / n_left >= thresholds.confidence
                        && n_both / n_left / (n_right / n) >= thresholds.lift
                    ? 1
                    : 0;
            }
        }
        const FoundRules found = find_rules(table, thresholds);
        EXPECT_GT(expected, 10U);
        EXPECT_EQ(found.rules.size(), expected);
        for (std::size_t n = 1; n < found.rules.size(); ++n)
            EXPECT_GE(found.rules[n - 1].lift, found.rules[n].lift);
    }

    TEST(AssociationRules, AThresholdThatIsReachedExactlyIsReached)
    {
        // 10 of 100 persons hold A, 5 of these B, and 25 of all: support 0.05, confidence 0.5, lift 2.
        ItemTable table { .persons = 100, .items = {} };
        for (const auto& [from, to] : { std::pair { 0, 10 }, { 5, 30 } }) {
            table.items.push_back({ .name = std::to_string(from),
                .left = from == 0,
                .right = from == 5,
                .holders = std::vector<std::uint64_t>(2, 0) });
            for (int person = from; person < to; ++person)
                table.items.back().holders[static_cast<std::size_t>(person / 64)] |= std::uint64_t { 1 }
                    << (person % 64);
        }
        EXPECT_EQ(find_rules(table, { .support = 0.05, .confidence = 0.5, .lift = 2.0 }).rules.size(), 1U);
        EXPECT_EQ(find_rules(table, { .support = 0.051 }).rules.size(), 0U);
        EXPECT_EQ(find_rules(table, { .confidence = 0.501 }).rules.size(), 0U);
        EXPECT_EQ(find_rules(table, { .lift = 2.001 }).rules.size(), 0U);
        const AssociationRule rule = find_rules(table, {}).rules.at(0);
        EXPECT_NEAR(rule.z, 2.5 / std::sqrt(2.5 * 0.975), 1e-12);
        for (const RuleThresholds& wrong : { RuleThresholds { .support = -0.1 }, RuleThresholds { .confidence = 1.1 },
                 RuleThresholds { .lift = NAN }, RuleThresholds { .most_left = 0 } })
            EXPECT_THROW((void)find_rules(table, wrong), InputError);
        EXPECT_THROW((void)find_rules({}, {}), InputError);
    }

    TEST(PValue, IsFishersExactOne)
    {
        // Fisher's tea: 8 cups, 4 with milk first, all guessed right: one of 70 splits, and its mirror.
        EXPECT_NEAR(p_of_both(8, 4, 4, 4), 2.0 / 70.0, 1e-9);
        EXPECT_NEAR(p_of_both(8, 4, 4, 3), 34.0 / 70.0, 1e-9);
        EXPECT_NEAR(p_of_both(8, 4, 4, 2), 1.0, 1e-9);
        // Of the published rules, all nine with HHL have the finding of 172: the chance is C(372, 163) / C(381, 172).
        EXPECT_NEAR(p_of_both(381, 9, 172, 9), 6.9e-4, 1e-5);
        EXPECT_EQ(p_of_both(10, 0, 5, 0), 1.0);
        EXPECT_EQ(p_of_both(10, 10, 5, 5), 1.0);
        // The approximation takes over where it has become exact enough.
        for (const std::size_t both : { 1010U, 1060U, 1130U }) {
            const std::size_t n = 5 * kExactUpTo, side = kExactUpTo;
            const double exact = p_of_both(n, side, side, both);
            const double variance = static_cast<double>(side) * side / n * (n - side) / n * (n - side) / (n - 1.0);
            const double approximate
                = std::erfc(std::abs(static_cast<double>(both) - 1000.0) / std::sqrt(2.0 * variance));
            EXPECT_NEAR(exact, approximate, 0.03);
        }
    }

    TEST(AdjustedPValues, AreThoseOfBenjaminiAndHochberg)
    {
        // Their example of 1995: 15 tests; at 5 % the first four are rejected.
        const std::vector<double> p { 0.0001, 0.0004, 0.0019, 0.0095, 0.0201, 0.0278, 0.0298, 0.0344, 0.0459, 0.3240,
            0.4262, 0.5719, 0.6528, 0.7590, 1.0 };
        const std::vector<double> adjusted = adjusted_p_values(p);
        EXPECT_EQ(std::ranges::count_if(adjusted, [](double one) { return one <= 0.05; }), 4);
        EXPECT_NEAR(adjusted[3], 0.0095 * 15 / 4, 1e-12);
        EXPECT_NEAR(adjusted[5], 0.0298 * 15 / 7, 1e-12) << "never more than that of a larger p";
        EXPECT_EQ(adjusted.back(), 1.0);
        const std::vector<double> turned(p.rbegin(), p.rend());
        EXPECT_NEAR(adjusted_p_values(turned)[11], adjusted[3], 1e-12) << "the order does not matter";
        EXPECT_TRUE(adjusted_p_values({}).empty());
    }

    fs::path written(const std::string& text)
    {
        const fs::path file = fs::path(testing::TempDir()) / "persons.csv";
        std::ofstream(file) << text;
        return file;
    }

    TEST(PersonItems, TakeTheEarliestYearThirdsAndNoItemBetween)
    {
        const fs::path file = written("year,person,A,cough\n"
                                      "2003,p1,9,1\n2002,p1,1,0\n" // the earlier year counts
                                      "2002,p2,2,1\n2003,p2,9,0\n"
                                      "2002,p3,3,\n2002,p4,4,1\n2002,p5,5,1\n2002,p6,6,1\n2002,p7,,1\n");
        const PersonItems items = items_of(file, { "A" });
        EXPECT_EQ(items.records, 9U);
        EXPECT_EQ(items.table.persons, 7U);
        ASSERT_EQ(items.table.items.size(), 3U);
        EXPECT_EQ(items.table.items[0].name, "A (High)");
        EXPECT_EQ(items.table.items[0].holders[0], 0b0110000U);
        EXPECT_EQ(items.table.items[1].name, "A (Low)");
        EXPECT_EQ(items.table.items[1].holders[0], 0b0000011U);
        EXPECT_EQ(items.table.items[2].name, "cough");
        EXPECT_EQ(items.table.items[2].holders[0], 0b1111010U);
        EXPECT_TRUE(items.table.items[0].left && !items.table.items[0].right);
        EXPECT_TRUE(!items.table.items[2].left && items.table.items[2].right);
        EXPECT_TRUE(items_of(written("person,cough,cold\np,1,0\n"), {}).table.items[0].left) << "without exposures";
    }

    TEST(PersonItems, ExposuresAreOneItemAndOnRequestEachItsOwn)
    {
        const fs::path file = written("person,A,B,cough\np1,1,6,0\np2,2,5,1\np3,3,4,0\np4,4,3,0\np5,5,2,0\np6,6,1,0\n");
        const auto names = [](const PersonItems& items) {
            std::vector<std::string> list;
            for (const Item& item : items.table.items)
                list.push_back(item.name);
            return list;
        };
        EXPECT_EQ(names(items_of(file, { "A", "B" })),
            (std::vector<std::string> { "A_B (High_Low)", "A_B (Low_High)", "cough" }));
        EXPECT_EQ(names(items_of(file, { "A", "B" }, true)),
            (std::vector<std::string> {
                "A (High)", "A (Low)", "A_B (High_Low)", "A_B (Low_High)", "B (High)", "B (Low)", "cough" }));
    }

    TEST(PersonItems, WrongRowsAndColumnsAreNamed)
    {
        const std::string text = "person,year,A,cough\np1,2002,1,0\np1,2002,2,1\np2,2002,x,1\np3,2002,1,2\n,2002,1,1\n"
                                 "p4,2002,1\np5,20x,1,0\np6,2002,3,1\n";
        const std::string message = test_support::message_of([&] { (void)items_of(written(text), { "A" }); });
        for (const char* part : { "6 rows are wrong", "persons.csv:3: is a second record of the person \"p1\"",
                 "persons.csv:4: \"x\" is no number", "persons.csv:5: \"2\" is no finding",
                 "persons.csv:6: has no person", "persons.csv:7: has 3 fields", "persons.csv:8: year is \"20x\"" })
            EXPECT_NE(message.find(part), std::string::npos) << part << "\n" << message;
        for (const char* order : { "person,year,A,cough\np,2001,1,0\np,2002,1,0\np,2002,1,0\n",
                 "person,year,A,cough\np,2002,1,0\np,2002,1,0\np,2001,1,0\n" })
            EXPECT_THROW((void)items_of(written(order), {}), InputError) << "whatever the order";
        EXPECT_THROW(
            (void)read_person_items(written("person,year,cough\np,2001,1\n"), { .year_column = "jahr" }), InputError);
        const PersonItems rest = read_person_items(written(text), { .exposures = { "A" }, .skip_bad = true });
        EXPECT_EQ(rest.table.persons, 2U);
        EXPECT_EQ(rest.bad.count, 6U);
        for (const char* wrong :
            { "", "person\np\n", "name,cough\np,1\n", "person,cough,cough\np,1,1\n", "person,cough\n" })
            EXPECT_THROW((void)items_of(written(wrong), {}), InputError) << wrong;
        EXPECT_THROW((void)items_of(written("person,A,cough\np,1,1\n"), { "B" }), InputError);
        EXPECT_THROW((void)items_of(written("person,A,cough\np,1,1\nq,1,0\nr,1,0\n"), { "A" }), InputError)
            << "equal numbers have no thirds";
        EXPECT_THROW((void)items_of(written("person,A,cough\np,,1\n"), { "A" }), InputError);
    }

} // namespace association_rules_test
} // namespace retractor::planner
