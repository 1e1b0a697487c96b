// Random strokes with the source's patterns: they keep every promise that the adaptive ones keep.

#include "mesh/base/error.h"
#include "tests/fuzz/cut_bodies.h"
#include "tests/fuzz/cut_invariants.h"
#include "tests/fuzz/cut_strokes.h"

#include <gtest/gtest.h>

#include <string>

namespace retractor::fuzz {
namespace cut_patterns_fuzz_test {

    /// Nothing is snapped here, so a blade that grazes a vertex may leave elements too thin to have a volume: a
    /// refusal.
    constexpr double kMostRefused = 0.2;

    class PatternStrokes : public testing::TestWithParam<std::tuple<mesh::Subdivision, const char*>> { };

    TEST_P(PatternStrokes, KeepEveryPromise)
    {
        const auto [subdivision, name] = GetParam();
        const Body body = make_body(name);
        const mesh::CutOptions options { .subdivision = subdivision, .snap = 0.0 };
        int strokes = 0, done = 0, refused = 0;
        for (std::uint64_t seed = 0; seed < 12; ++seed) {
            std::mt19937_64 random(seed);
            mesh::CutSession session(body.mesh);
            const State first(session);
            RandomStroke last;
            for (int i = 0; i < 2; ++i) {
                const State before(session);
                const RandomStroke stroke = random_stroke(body, session, before, last, random);
                ++strokes;
                Findings findings;
                try {
                    const mesh::CutResult result = session.cut(stroke.blade, options);
                    const State after(session);
                    check_sound(after, findings);
                    if (result.status == mesh::CutStatus::done) {
                        ++done;
                        check_cut(before, after, body.mesh, stroke.blade, options, result.report, findings);
                    } else {
                        EXPECT_TRUE(same_bits(after, before));
                    }
                } catch (const Error& error) {
                    EXPECT_TRUE(is_named_refusal(error)) << name << " seed " << seed << ": " << error.what();
                    ++refused;
                    EXPECT_TRUE(same_bits(State(session), before));
                }
                for (const Finding& finding : findings)
                    ADD_FAILURE() << name << " seed " << seed << " stroke " << i << " (" << stroke.kind
                                  << "): " << finding.invariant << ": " << finding.detail;
                last = stroke;
            }
            while (session.can_undo())
                session.undo();
            EXPECT_TRUE(same_bits(State(session), first)) << "seed " << seed;
        }
        EXPECT_GE(2 * done, strokes) << "most strokes miss: little is tested";
        EXPECT_LE(refused, kMostRefused * strokes);
    }

    INSTANTIATE_TEST_SUITE_P(All, PatternStrokes,
        testing::Combine(testing::Values(mesh::Subdivision::general, mesh::Subdivision::intermediate_5,
                             mesh::Subdivision::intermediate_11),
            testing::Values("box", "sphere")));

    TEST(PatternStrokesFreehand, GrowAndAreOneCutToUndo)
    {
        const mesh::TetMesh box = mesh::kuhn_box(12, 8, 4, 3.0);
        for (const mesh::Subdivision subdivision : { mesh::Subdivision::general, mesh::Subdivision::intermediate_5 }) {
            const mesh::CutOptions options { .subdivision = subdivision, .snap = 0.0 };
            mesh::CutSession session(box);
            const State before(session);
            mesh::Blade drawn {
                .line = { { 5.2, 10.3, 12.0 } }, .directions = { { 0.05, 0.1, -1.0 } }, .depth_mm = 6.1
            };
            Mirror mirror(before);
            Findings findings;
            for (int i = 0; i < 5; ++i) {
                drawn.line.push_back(drawn.line.back() + Vec3(4.7, 0.55, 0.0));
                const mesh::CutResult step = session.extend_stroke(drawn, options);
                ASSERT_EQ(step.status, mesh::CutStatus::done) << step.message;
                mirror.follow(step.delta, findings);
                check_sound(State(session), findings);
            }
            const mesh::CutResult last = session.finish_stroke();
            ASSERT_EQ(last.status, mesh::CutStatus::done) << last.message;
            mirror.follow(last.delta, findings);
            const State after(session);
            check_sound(after, findings);
            check_cut(before, after, box, drawn, options, last.report, findings);
            mirror.compare(after, findings);
            session.undo();
            EXPECT_TRUE(same_bits(State(session), before));
            for (const Finding& finding : findings)
                ADD_FAILURE() << finding.invariant << ": " << finding.detail;
        }
    }

} // namespace cut_patterns_fuzz_test
} // namespace retractor::fuzz
