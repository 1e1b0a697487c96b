#include "mesh/cutting/cut_session.h"
#include "mesh/cutting/store/blade.h"
#include "mesh/cutting/surface_follower.h"

#include "mesh/base/error.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <random>
#include <tuple>
#include <vector>

namespace retractor::mesh {
namespace surface_follower_test {

    using Corners = std::array<std::array<double, 3>, 3>;
    using Shown = std::vector<std::tuple<TetId, int, Corners, Label>>;

    Shown shown(const SurfaceFollower& follower)
    {
        Shown faces;
        for (const SurfaceFace& face : follower.faces()) {
            Corners corners {};
            for (std::size_t i = 0; i < 3; ++i) {
                const Vec3& p = follower.position(face.vertices[i]);
                corners[i] = { p.x(), p.y(), p.z() };
            }
            faces.emplace_back(face.face.tet, face.face.corner, corners, face.label);
        }
        std::sort(faces.begin(), faces.end());
        return faces;
    }

    Shown expected(const CutSession& session)
    {
        SlotMap map;
        const TetMesh mesh = session.compact_mesh(&map);
        Shown faces;
        for (const TetFace& face : boundary_faces(mesh)) {
            Corners corners {};
            const auto v = face_vertices(mesh, face);
            for (std::size_t i = 0; i < 3; ++i)
                corners[i] = { mesh.vertices(v[i], 0), mesh.vertices(v[i], 1), mesh.vertices(v[i], 2) };
            faces.emplace_back(map.tet_slot[static_cast<std::size_t>(face.tet)], face.corner, corners,
                mesh.labels[static_cast<std::size_t>(face.tet)]);
        }
        std::sort(faces.begin(), faces.end());
        return faces;
    }

    TetMesh layered_box()
    {
        TetMesh box = kuhn_box(9, 9, 4, 3.0);
        for (std::size_t t = 0; t < box.labels.size(); ++t)
            box.labels[t] = static_cast<Label>(1 + t % 5);
        return box;
    }

    Blade random_blade(std::mt19937_64& random)
    {
        const auto in
            = [&](double low, double high) { return std::uniform_real_distribution<double>(low, high)(random); };
        const Vec3 from(in(1.0, 26.0), in(1.0, 26.0), 12.0);
        const double angle = in(0.0, 6.28);
        return { .line = { from, from + in(5.0, 15.0) * Vec3(std::cos(angle), std::sin(angle), 0.0) },
            .directions = { { in(-0.3, 0.3), in(-0.3, 0.3), -1.0 } },
            .depth_mm = in(2.0, 9.0) };
    }

    TEST(SurfaceFollower, StartsWithTheWholeSurface)
    {
        const TetMesh box = layered_box();
        const SurfaceFollower follower(box);
        EXPECT_EQ(follower.faces().size(), boundary_faces(box).size());
        EXPECT_EQ(shown(follower), expected(CutSession(box)));
    }

    TEST(SurfaceFollower, IsTheSurfaceAfterRandomCutsUndoAndRedo)
    {
        const TetMesh box = layered_box();
        CutSession session(box);
        SurfaceFollower follower(box);
        std::mt19937_64 random(7);
        const auto same = [&] { return shown(follower) == expected(session); };
        int done = 0;
        for (int i = 0; i < 40; ++i) {
            const auto dice = random() % 5;
            if (dice == 0 && session.can_undo()) {
                follower.follow(session.undo());
            } else if (dice == 1 && session.can_redo()) {
                follower.follow(session.redo());
            } else {
                try {
                    const CutResult result = session.cut(random_blade(random));
                    follower.follow(result.delta);
                    done += result.status == CutStatus::done ? 1 : 0;
                } catch (const SolverError&) { // a refusal: nothing has changed
                }
            }
            ASSERT_TRUE(same()) << "after change " << i;
        }
        EXPECT_GT(done, 10);
        while (session.can_undo())
            follower.follow(session.undo());
        EXPECT_EQ(shown(follower), shown(SurfaceFollower(box)));
    }

    TEST(SurfaceFollower, FollowsAFreehandStroke)
    {
        const TetMesh box = layered_box();
        CutSession session(box);
        SurfaceFollower follower(box);
        Blade drawn { .line = { { 4.1, 12.7, 12.0 } }, .directions = { { 0.1, 0.1, -1.0 } }, .depth_mm = 5.0 };
        for (int i = 0; i < 4; ++i) {
            drawn.line.push_back(drawn.line.back() + Vec3(4.4, 0.7, 0.0));
            follower.follow(session.extend_stroke(drawn).delta);
            ASSERT_EQ(shown(follower), expected(session)) << "step " << i;
        }
        follower.follow(session.finish_stroke().delta);
        EXPECT_EQ(shown(follower), expected(session));
        follower.follow(session.undo());
        EXPECT_EQ(shown(follower), shown(SurfaceFollower(box)));
    }

    TEST(SurfaceFollower, SaysWhichPlacesAreNew)
    {
        const TetMesh box = layered_box();
        CutSession session(box);
        SurfaceFollower follower(box);
        std::mt19937_64 random(3);
        for (int i = 0; i < 6; ++i) {
            const std::vector<SurfaceFace> before = follower.faces();
            follower.follow(session.cut(random_blade(random)).delta);
            const std::vector<SurfaceFace>& after = follower.faces();
            const auto& changed = follower.changed();
            for (std::size_t place = 0; place < after.size(); ++place)
                if (!std::binary_search(changed.begin(), changed.end(), place)) {
                    ASSERT_LT(place, before.size());
                    ASSERT_EQ(after[place].vertices, before[place].vertices);
                    ASSERT_EQ(after[place].face.tet, before[place].face.tet);
                }
        }
    }

    TEST(SurfaceFollower, PutsAPieceBackOnABareFace)
    {
        const TetMesh box = kuhn_box(2, 2, 2, 1.0);
        SurfaceFollower follower(box);
        MeshDelta removal;
        for (const TetId t : { 0, 7, 20 })
            removal.tets_gone.push_back({ t, { box.tet(t)[0], box.tet(t)[1], box.tet(t)[2], box.tet(t)[3] }, 1, t });
        const Shown whole = shown(follower);
        follower.follow(removal);
        EXPECT_NE(shown(follower), whole);
        follower.follow(inverse(removal));
        EXPECT_EQ(shown(follower), whole);
    }

    TEST(SurfaceFollower, RefusesADeltaThatDoesNotFit)
    {
        const TetMesh box = kuhn_box(2, 2, 2, 1.0);
        MeshDelta delta;
        delta.tets_gone.push_back({ 3, { 0, 1, 2, 5 }, 1, 3 });
        SurfaceFollower follower(box);
        try {
            follower.follow(delta);
            FAIL() << "no refusal";
        } catch (const InputError& error) {
            EXPECT_STREQ(error.what(), "the delta does not fit the surface it should change");
            EXPECT_EQ(error.where(), "element 3");
        }
    }

} // namespace surface_follower_test
} // namespace retractor::mesh
