#include "planner/ports/port_search.h"

#include "mesh/base/error.h"
#include "planner/case/import_case.h"
#include "tests/support/synthetic_chest.h"
#include "tests/support/temporary_folder.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>

namespace retractor::planner {
namespace port_search_test {

    /// The round chest as a case without a CT.
    Case chest_case(const std::filesystem::path& folder)
    {
        ImportedCase imported;
        imported.labels = std::make_shared<mesh::LabelVolume>(test_support::synthetic_chest());
        return write_import(imported, folder / "case.json");
    }

    TEST(PortSearch, ProposesPortsWithRoomForEachOther)
    {
        const test_support::TemporaryFolder folder;
        Patient patient(chest_case(folder.path));
        for (const bool left : { true, false }) {
            const PortSearch search
                = find_ports(patient, { .target = { .label = "heart" }, .left = left, .lowest_space = 7 }, 3);
            ASSERT_FALSE(search.found.empty()) << left;
            for (const PortPlan& plan : search.found) {
                EXPECT_GT(plan.seen, 0.0);
                EXPECT_LE(plan.seen, 1.0);
                EXPECT_LE(plan.worked_on, plan.seen);
                EXPECT_GE(plan.between_deg, kLeastBetweenDeg);
                EXPECT_LE(plan.between_deg, kMostBetweenDeg);
                EXPECT_GE(plan.nearest_shafts_mm, kShaftsApartMm);
                const Port* ports[] = { &plan.scope, &plan.instruments[0], &plan.instruments[1] };
                for (int n = 0; n < 3; ++n) {
                    EXPECT_GE((ports[n]->skin - ports[(n + 1) % 3]->skin).norm(), kPortsApartMm);
                    EXPECT_EQ(ports[n]->left, left);
                    EXPECT_EQ(ports[n]->skin.x() > 0.0, left) << "x of LPS grows to the left";
                    // On the skin of the round chest.
                    EXPECT_NEAR(
                        std::hypot(ports[n]->skin.x(), ports[n]->skin.y()), test_support::ChestShape {}.radius, 1.5);
                }
            }
            for (std::size_t n = 1; n < search.found.size(); ++n)
                EXPECT_GE(search.found[n - 1].points, search.found[n].points);
        }
    }

    TEST(PortSearch, RefusesWhatIsNotThere)
    {
        const test_support::TemporaryFolder folder;
        Patient patient(chest_case(folder.path));
        EXPECT_THROW(find_ports(patient, { .target = { .label = "spleen" } }, 3), InputError);
        EXPECT_THROW(find_ports(patient, { .target = { .label = "heart" }, .highest_space = 6, .lowest_space = 4 }, 3),
            InputError);
        EXPECT_THROW(
            find_ports(patient, { .target = { .label = "heart" }, .highest_space = 10, .lowest_space = 11 }, 3),
            InputError)
            << "this chest has eight ribs";
    }

    TEST(PortSearch, NamesPlacesAsSurgeonsDo)
    {
        EXPECT_EQ(place_in_words({ .left = false, .space = 4, .angle_deg = 108.0 }),
            "right 4th space, anterior axillary line");
        EXPECT_EQ(place_in_words({ .left = true, .space = 3, .angle_deg = 92.0 }), "left 3rd space, mid-axillary line");
    }

} // namespace port_search_test
} // namespace retractor::planner
