#include "fem/interactive/multifrontal_factor.h"

#include "mesh/base/error.h"
#include "tests/support/random_entries.h"
#include "tests/support/reference_problems.h"

#include <gtest/gtest.h>

#include <cmath>

namespace retractor::fem {
namespace multifrontal_factor_test {

    using namespace test_support;

    /// A box fixed at the bottom, to be cut along its middle.
    struct Box {
        Box()
            : session(mesh::kuhn_box(12, 8, 4, 4.0))
            , K(session, std::vector<Material> { test_support::material(0.5, 0.3), test_support::material(0.5, 0.3) })
            , fixed(K.slot_count(), 0)
        {
            for (VertexId v = 0; v < static_cast<VertexId>(K.slot_count()); ++v) {
                const Vec3& p = K.position(v);
                if (p.z() < 1e-9)
                    fixed[static_cast<std::size_t>(v)] = 1;
                else if (std::abs(p.y() - 16.0) < 6.0)
                    open.push_back(v);
            }
        }
        std::vector<std::uint8_t> free() const
        {
            std::vector<std::uint8_t> active;
            for (const std::uint8_t f : fixed)
                active.push_back(f == 0 ? 1 : 0);
            return active;
        }
        mesh::CutSession session;
        OnlineStiffness K;
        std::vector<std::uint8_t> fixed;
        std::vector<VertexId> open;
    };
    constexpr std::size_t kSmallParts = 20;

    TEST(Dissection, HasEachFreeVertexOnceAndStrangersDoNotTouch)
    {
        const Box box;
        const Dissection dissection = dissect(box.K, box.fixed, box.open, kSmallParts);
        ASSERT_GT(dissection.parts.size(), 5U);
        std::vector<std::int32_t> part(box.K.slot_count(), -1);
        std::vector<std::uint8_t> is_open(box.K.slot_count(), 0);
        for (const VertexId v : box.open)
            is_open[static_cast<std::size_t>(v)] = 1;
        for (std::size_t p = 0; p < dissection.parts.size(); ++p) {
            EXPECT_LT(dissection.parts[p].parent, static_cast<std::int32_t>(p));
            for (const VertexId v : dissection.parts[p].closed)
                EXPECT_EQ(is_open[static_cast<std::size_t>(v)], 0);
            for (const auto* list : { &dissection.parts[p].closed, &dissection.parts[p].open })
                for (const VertexId v : *list) {
                    EXPECT_EQ(part[static_cast<std::size_t>(v)], -1) << v;
                    part[static_cast<std::size_t>(v)] = static_cast<std::int32_t>(p);
                }
        }
        const auto above = [&](std::int32_t high, std::int32_t low) {
            while (low >= 0 && low != high)
                low = dissection.parts[static_cast<std::size_t>(low)].parent;
            return low == high;
        };
        for (VertexId v = 0; v < static_cast<VertexId>(part.size()); ++v) {
            const std::int32_t own = part[static_cast<std::size_t>(v)];
            EXPECT_EQ(own < 0, box.fixed[static_cast<std::size_t>(v)] != 0) << v;
            for (const VertexId w : box.K.row(v).column)
                if (const std::int32_t other = part[static_cast<std::size_t>(w)]; own >= 0 && other >= 0) {
                    EXPECT_TRUE(above(own, other) || above(other, own)) << v << " " << w;
                }
        }
        const Dissection whole = dissect(box.K, box.fixed, box.open, box.open.size());
        ASSERT_EQ(whole.parts.size(), 1U);
        EXPECT_DOUBLE_EQ(whole.work, std::pow(3.0 * static_cast<double>(box.open.size()), 3) / 3.0); // one dense front
    }

    TEST(MultifrontalFactor, SolvesLoadsAnywhereWithSomeVerticesHeldAndOthersOpenedLater)
    {
        const Box box;
        MultifrontalFactor body(box.K, dissect(box.K, box.fixed, box.open, kSmallParts));
        const auto rows = 3 * static_cast<Eigen::Index>(box.K.slot_count());
        constexpr Eigen::Index kCases = 2;
        const std::vector<std::uint8_t> active = box.free();
        const auto expect_solved = [&](const std::set<VertexId>& held) {
            ASSERT_TRUE(body.update(box.K, active, held));
            Eigen::MatrixXd load = test_support::random_entries(rows, kCases, 3);
            const auto rest = [&](Eigen::MatrixXd& at) {
                for (VertexId v = 0; v < static_cast<VertexId>(active.size()); ++v)
                    if (active[static_cast<std::size_t>(v)] == 0 || held.contains(v))
                        at.middleRows(3 * v, 3).setZero();
            };
            rest(load);
            const Eigen::MatrixXd x = body.solve(load);
            Eigen::MatrixXd r = load - box.K.multiply(x);
            rest(r);
            EXPECT_LT(r.norm(), 1e-12 * load.norm()); // round-off of a well conditioned system
            for (const VertexId v : held)
                EXPECT_EQ(x.middleRows(3 * v, 3).norm(), 0.0);
        };
        expect_solved({});
        expect_solved({ box.open[3], box.open[40], box.open[41] });
        expect_solved({ box.open[40] }); // two are let go
        std::vector<VertexId> closed;
        for (VertexId v = 0; v < static_cast<VertexId>(active.size()); ++v)
            if (body.closed(v))
                closed.push_back(v);
        ASSERT_GT(closed.size(), 30U);
        const VertexId first = closed.front(), last = closed.back();
        body.open(box.K, { first, last });
        EXPECT_FALSE(body.closed(first));
        expect_solved({ first, box.open[7] });
        EXPECT_GT(body.reciprocal_condition(), 0.0);
        EXPECT_GT(body.bytes(), 0U);
    }

    TEST(MultifrontalFactor, ClosedVerticesThatChangeAreNamedUntilTheyAreAsTheyWere)
    {
        Box box;
        MultifrontalFactor body(box.K, dissect(box.K, box.fixed, box.open, kSmallParts));
        VertexId closed = 0;
        while (!body.closed(closed))
            ++closed;
        body.touch(closed, box.K.row(closed));
        EXPECT_TRUE(body.changed_but_closed(box.K).empty());
        std::vector<double> bed(box.K.slot_count(), 0.0);
        bed[static_cast<std::size_t>(closed)] = 0.1;
        box.K.set_bed(bed);
        EXPECT_EQ(body.changed_but_closed(box.K), std::vector<VertexId> { closed });
        box.K.set_bed({});
        EXPECT_TRUE(body.changed_but_closed(box.K).empty());
    }

    TEST(MultifrontalFactor, ABodyThatNothingHoldsIsRefused)
    {
        Box box;
        std::fill(box.fixed.begin(), box.fixed.end(), std::uint8_t { 0 });
        const auto corner = static_cast<std::size_t>(box.open.front());
        box.fixed[corner] = 1; // it still turns round this vertex
        std::erase(box.open, static_cast<VertexId>(corner));
        try {
            const MultifrontalFactor body(box.K, dissect(box.K, box.fixed, box.open, kSmallParts));
            EXPECT_LT(body.reciprocal_condition(), 1e-11); // or round-off is taken for stiffness
        } catch (const SolverError& error) {
            EXPECT_NE(std::string(error.what()).find("not positive definite"), std::string::npos);
        }
    }

} // namespace multifrontal_factor_test
} // namespace retractor::fem
