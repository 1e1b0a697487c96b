#include "tests/fuzz/fuzz_targets.h"

#include "datasets/io/label_table.h"
#include "mesh/base/error.h"
#include "planner/case/case_io.h"

#include <stdexcept>
#include <string>

namespace retractor::fuzz {

namespace {

    /// Runs the reader; a refusal must say what and where.
    template <typename Read> Answer answer_of(Read&& read)
    {
        try {
            read();
        } catch (const InputError& error) {
            if (error.where().empty() || std::string(error.what()).empty())
                throw std::logic_error(std::string("a refusal must say what and where: ") + error.what());
            return Answer::refused;
        }
        return Answer::accepted;
    }

    planner::Approach sample_approach(const std::string& name)
    {
        planner::Approach approach;
        approach.name = name;
        approach.template_name = "points";
        approach.incision = { { 0.1, 2.0, -3e-17 }, { 4.0, 1.0 / 3.0, 60.0 }, { 5.0, 0.0, 150.0 } };
        approach.directions = { Vec3::UnitY(), Vec3(0.6, 0.8, 0.0), Vec3::UnitY() };
        approach.depth_mm = 37.5;
        approach.wall_thickness_mm = { 30.0, 31.0, 32.0 };
        approach.hook_depth_mm = { 15.0, 16.0, 17.0 };
        approach.target.label = "aneurysm";
        approach.retracted = { "lung" };
        approach.uncut_labels = { "rib" };
        approach.rationale = "because \"it\" is so: größer\n";
        return approach;
    }

    mesh::LabelTable sample_labels()
    {
        return { { 1, "spine", "bone", mesh::Role::wall }, { 2, "rib", "bone", mesh::Role::wall },
            { 3, "lung", "lung", mesh::Role::voxel }, { 700, "aneurysm", "vessel", mesh::Role::target },
            { 65535, "heart", "heart", mesh::Role::at_risk } };
    }

    planner::Case smallest_case()
    {
        planner::Case sample;
        sample.labels = { .path = "labels.nrrd", .sha256 = std::string(64, 'a') };
        sample.label_table = sample_labels();
        return sample;
    }

    planner::Case whole_case()
    {
        planner::Case sample = smallest_case();
        sample.ct = planner::FileReference { .path = "ct/series", .sha256 = std::string(64, '0') };
        planner::add_approach(sample, sample_approach("first"));
        for (const int side : { 1, -1 })
            for (const double along_mm : { 40.0, 110.0 })
                sample.approaches.back().hooks.push_back({ .name = "hook_" + std::to_string(side * along_mm),
                    .side = side,
                    .along_mm = along_mm,
                    .depth_mm = 15.0,
                    .direction = side * Vec3::UnitX(),
                    .opening_mm = 20.0 });
        planner::Approach second = sample_approach("second");
        second.target = { .label = {}, .centre = Vec3(0.1, -1e-17, 1e3 / 7.0), .radius_mm = 0.3 };
        planner::add_approach(sample, second);
        return sample;
    }

} // namespace

Answer feed_case(const std::string& text)
{
    return answer_of([&] {
        const std::string written = planner::case_to_json(planner::case_from_json(text, "folder"));
        if (planner::case_to_json(planner::case_from_json(written, "folder")) != written)
            throw std::logic_error("a case changes when it is written and read again");
    });
}

Answer feed_label_table(const std::string& text)
{
    return answer_of([&] {
        const mesh::LabelTable table = datasets::label_table_from_json(text, "table");
        const std::string written = datasets::label_table_to_json(table);
        if (datasets::label_table_to_json(datasets::label_table_from_json(written, "table")) != written)
            throw std::logic_error("a label table changes when it is written and read again");
    });
}

std::vector<std::string> case_seeds()
{
    return { planner::case_to_json(smallest_case()), planner::case_to_json(whole_case()) };
}

std::vector<std::string> label_table_seeds()
{
    return { datasets::label_table_to_json({}), datasets::label_table_to_json(sample_labels()) };
}

} // namespace retractor::fuzz
