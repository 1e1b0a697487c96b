#include "planner/case/label_session.h"

#include "mesh/base/error.h"
#include "tests/planner/case/two_ribs.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

namespace retractor::planner {
namespace label_session_test {

    const mesh::LabelFlags kNothingKept(mesh::kLabelCount, 0);

    std::shared_ptr<const mesh::LabelVolume> image() { return test_support::two_ribs(); }

    Case planned()
    {
        Case c;
        c.label_table = image()->table;
        c.estimated_labels = { "rib_left_5" };
        Approach approach;
        approach.name = "one";
        approach.uncut_labels = { "rib_left_4", "rib_left_5" };
        c.approaches = { approach };
        return c;
    }

    LabelSession::MakeEdit ball(double x, Label with)
    {
        return [=](const mesh::LabelVolume& labels) {
            return datasets::painted(labels, { .path = { Vec3(x, 10, 10) }, .radius_mm = 2.0 }, with, kNothingKept);
        };
    }

    TEST(LabelSession, StepsAreTakenBackAndMadeAgain)
    {
        LabelSession session(planned(), image());
        EXPECT_FALSE(session.changed());
        EXPECT_TRUE(session.edit(ball(5, 2)));
        const auto painted = session.labels()->voxels;
        session.join("rib_left_4", "rib_left_5");
        session.rename("rib_left_5", "rib_left_3");
        const auto renamed = session.labels();
        EXPECT_EQ(session.to_undo(), "rename left rib 5");
        EXPECT_EQ(std::ranges::count(renamed->voxels, 2), 0);
        EXPECT_NE(mesh::find_label(session.table(), "rib_left_3"), nullptr);
        session.undo();
        session.undo();
        EXPECT_EQ(session.labels()->voxels, painted);
        EXPECT_EQ(session.table().size(), 3U);
        session.undo();
        EXPECT_EQ(session.labels()->voxels, image()->voxels);
        EXPECT_FALSE(session.changed());
        EXPECT_FALSE(session.to_undo());
        while (session.to_redo())
            session.redo();
        EXPECT_EQ(session.labels()->voxels, renamed->voxels);
        EXPECT_NE(mesh::find_label(session.table(), "rib_left_3"), nullptr);
    }

    TEST(LabelSession, VolumesFollowTheEdits)
    {
        LabelSession session(planned(), image());
        const auto counted = [&](Label label) {
            return static_cast<double>(std::ranges::count(session.labels()->voxels, label)) / 1000.0; // of 1 mm3
        };
        const auto right = [&] {
            for (Label label = 0; label <= 3; ++label)
                EXPECT_NEAR(session.volume_ml(label), counted(label), 1e-12) << label;
        };
        right();
        session.edit(ball(5, 2));
        right();
        session.edit(ball(7, 3), LabelSession::Part::instead);
        right();
        session.join("rib_left_4", "rib_left_5");
        right();
        session.undo();
        right();
        session.undo();
        right();
    }

    TEST(LabelSession, AStrokeIsOneStep)
    {
        LabelSession session(planned(), image());
        session.edit(ball(4, 2));
        session.edit(ball(8, 2), LabelSession::Part::more);
        session.edit(ball(12, 2), LabelSession::Part::more);
        session.edit(ball(12, 3)); // another stroke
        session.undo();
        session.undo();
        EXPECT_EQ(session.labels()->voxels, image()->voxels);
    }

    TEST(LabelSession, APartMayTakeThePlaceOfTheLastStep)
    {
        LabelSession session(planned(), image());
        session.edit(ball(4, 2));
        session.edit(ball(10, 3), LabelSession::Part::instead);
        LabelSession other(planned(), image());
        other.edit(ball(10, 3));
        EXPECT_EQ(session.labels()->voxels, other.labels()->voxels);
        const auto refuses = [](const mesh::LabelVolume&) -> datasets::LabelEdit { throw InputError("no"); };
        EXPECT_THROW(session.edit(refuses, LabelSession::Part::instead), InputError);
        EXPECT_EQ(session.labels()->voxels, other.labels()->voxels) << "the step stays";
        session.undo();
        EXPECT_EQ(session.labels()->voxels, image()->voxels);
    }

    TEST(LabelSession, PicturesThatHoldOlderStatesDoNotDisturb)
    {
        LabelSession session(planned(), image()), alone(planned(), image());
        std::shared_ptr<const mesh::LabelVolume> shown; // as the window holds the last state
        std::vector<std::shared_ptr<const mesh::LabelVolume>> held; // as a slow picture may
        for (int n = 0; n < 12; ++n) {
            const auto make = ball(2.0 + n, n % 2 == 0 ? 2 : 3);
            session.edit(make);
            alone.edit(make);
            shown = session.labels();
            if (n % 5 == 0)
                held.push_back(shown);
            if (n % 4 == 3) {
                session.undo();
                alone.undo();
            }
            ASSERT_EQ(session.labels()->voxels, alone.labels()->voxels) << n;
        }
    }

    TEST(LabelSession, WhatAPictureHoldsStaysAsItWas)
    {
        LabelSession session(planned(), image());
        const auto held = session.labels();
        session.edit(ball(5, 2));
        EXPECT_EQ(held->voxels, image()->voxels);
        EXPECT_NE(session.labels()->voxels, image()->voxels);
    }

    TEST(LabelSession, AnEditThatChangesNothingIsNoStep)
    {
        LabelSession session(planned(), image());
        EXPECT_FALSE(session.edit(ball(5, 1)));
        EXPECT_FALSE(session.changed());
        EXPECT_THROW(session.edit(ball(5, 99)), InputError);
        EXPECT_THROW(session.rename("rib_left_4", "rib_left_5"), InputError);
        EXPECT_THROW(session.join("rib_left_4", "liver"), InputError);
        EXPECT_THROW(session.add_label("muscle", "muscle", mesh::Role::wall), InputError);
        EXPECT_FALSE(session.changed());
    }

    TEST(LabelSession, CorrectsTheCaseAsItIsNow)
    {
        LabelSession session(planned(), image());
        session.rename("rib_left_4", "rib_left_3");
        session.confirm("rib_left_5");
        session.add_label("aneurysm", "vessel", mesh::Role::target);
        EXPECT_FALSE(session.is_estimated("rib_left_5"));
        Case now = planned(); // meanwhile it has another approach
        now.approaches.push_back(now.approaches.front());
        now.approaches.back().name = "two";
        const Case corrected = session.corrected(now);
        ASSERT_EQ(corrected.approaches.size(), 2U);
        for (const Approach& approach : corrected.approaches)
            EXPECT_EQ(approach.uncut_labels.front(), "rib_left_3");
        EXPECT_TRUE(corrected.estimated_labels.empty());
        ASSERT_NE(mesh::find_label(corrected.label_table, "aneurysm"), nullptr);
        EXPECT_EQ(mesh::find_label(corrected.label_table, "aneurysm")->id, 4);
    }

} // namespace label_session_test
} // namespace retractor::planner
