#include "planner/case/unsaved_labels.h"

#include "mesh/base/error.h"
#include "tests/planner/case/two_ribs.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/test_help.h"

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <memory>
#include <string>

namespace retractor::planner {
namespace unsaved_labels_test {

    std::shared_ptr<mesh::LabelVolume> image() { return test_support::two_ribs(); }

    Case planned()
    {
        Case planned_case;
        planned_case.label_table = image()->table;
        planned_case.estimated_labels = { "rib_left_5" };
        return planned_case;
    }

    LabelSession::MakeEdit ball(double x, Label with)
    {
        return [=](const mesh::LabelVolume& labels) {
            return datasets::painted(labels, { .path = { Vec3(x, 10, 10) }, .radius_mm = 2.0 }, with,
                mesh::LabelFlags(mesh::kLabelCount, 0));
        };
    }

    /// Every kind of step, one of them of two parts.
    LabelSession corrected_session()
    {
        LabelSession session(planned(), image());
        session.edit(ball(5, 2));
        session.edit(ball(8, 2), LabelSession::Part::more);
        session.confirm("rib_left_5");
        session.add_label("aneurysm", "vessel", mesh::Role::target);
        session.edit(ball(14, 4));
        session.rename("rib_left_4", "rib_left_3");
        session.join("rib_left_3", "rib_left_5");
        return session;
    }

    TEST(UnsavedLabels, AreMadeAgainAsTheyWere)
    {
        const test_support::TemporaryFolder folder;
        const auto file = folder / "case.unsaved-labels";
        const LabelSession before = corrected_session();
        write_unsaved_labels(file, sum_of(*image()), before.steps());
        const auto steps = read_unsaved_labels(file, sum_of(*image()));
        ASSERT_TRUE(steps);
        LabelSession after(planned(), image());
        after.make_steps(*steps);
        EXPECT_EQ(after.labels()->voxels, before.labels()->voxels);
        ASSERT_EQ(after.table().size(), before.table().size());
        for (std::size_t n = 0; n < after.table().size(); ++n)
            EXPECT_EQ(after.table()[n].name, before.table()[n].name);
        EXPECT_FALSE(after.is_estimated("rib_left_5"));
        EXPECT_EQ(after.steps().size(), before.steps().size());
        EXPECT_EQ(after.to_undo(), before.to_undo());
        while (after.to_undo())
            after.undo();
        EXPECT_EQ(after.labels()->voxels, image()->voxels);
    }

    TEST(UnsavedLabels, WithoutStepsThereIsNoFile)
    {
        const test_support::TemporaryFolder folder;
        const auto file = folder / "case.unsaved-labels";
        EXPECT_FALSE(read_unsaved_labels(file, 1));
        write_unsaved_labels(file, 1, corrected_session().steps());
        EXPECT_TRUE(std::filesystem::exists(file));
        write_unsaved_labels(file, 1, {});
        EXPECT_FALSE(std::filesystem::exists(file));
        EXPECT_NO_THROW(write_unsaved_labels(file, 1, {}));
    }

    TEST(UnsavedLabels, OfOtherLabelsAreRefused)
    {
        const test_support::TemporaryFolder folder;
        const auto file = folder / "case.unsaved-labels";
        write_unsaved_labels(file, sum_of(*image()), corrected_session().steps());
        const auto other = image();
        other->voxels[7] = 2;
        const auto refusal = [&](const mesh::LabelVolume& labels) {
            return test_support::message_of([&] { (void)read_unsaved_labels(file, sum_of(labels)); });
        };
        EXPECT_NE(refusal(*other).find("labels that have changed since"), std::string::npos);
        const auto renamed = image();
        renamed->table[1].name = "rib_left_6";
        EXPECT_NE(refusal(*renamed).find("labels that have changed since"), std::string::npos);
        EXPECT_EQ(refusal(*image()), "");
        // Steps that do not fit are refused even so.
        LabelSession session(planned(), other);
        std::vector<LabelStep> steps = corrected_session().steps();
        steps.front().edits.front().before.front() = 3;
        EXPECT_THROW(session.make_steps(steps), InputError);
        steps.front().edits.front().voxels.front() = 1'000'000;
        EXPECT_THROW(session.make_steps(steps), InputError);
    }

    TEST(UnsavedLabels, ADamagedFileIsNamed)
    {
        const test_support::TemporaryFolder folder;
        const auto file = folder / "case.unsaved-labels";
        write_unsaved_labels(file, sum_of(*image()), corrected_session().steps());
        std::ifstream in(file, std::ios::binary);
        const std::string whole(std::istreambuf_iterator<char>(in), {});
        const auto refused = [&](const std::string& content) {
            std::ofstream(file, std::ios::binary) << content;
            return test_support::message_of([&] { (void)read_unsaved_labels(file, sum_of(*image())); });
        };
        std::string changed = whole;
        changed[whole.size() / 2] = static_cast<char>(changed[whole.size() / 2] ^ 1);
        for (const std::string& content : { std::string(), whole.substr(0, 10), whole.substr(0, 30),
                 whole.substr(0, whole.size() / 2), changed, "retractor unsaved labels 9\n" + whole })
            EXPECT_NE(refused(content).find("damaged"), std::string::npos) << content.size();
        EXPECT_EQ(refused(whole), "");
    }

} // namespace unsaved_labels_test
} // namespace retractor::planner
