#include "tests/support/block_case.h"

#include "datasets/io/volume_io.h"
#include "planner/approach/approach_templates.h"
#include "planner/approach/hooks.h"
#include "planner/case/case_io.h"

#include <gtest/gtest.h>

#include <filesystem>

namespace retractor::test_support {

planner::Case block_case(const std::string& name, const datasets::Phantom& phantom)
{
    planner::Case planned_case;
    planned_case.folder = std::filesystem::path(testing::TempDir()) / ("plan_" + name);
    std::filesystem::create_directories(planned_case.folder);
    datasets::write_label_volume(planned_case.folder / "labels.nrrd", phantom.labels);
    planned_case.labels = planner::make_reference(planned_case.folder, planned_case.folder / "labels.nrrd");
    planned_case.label_table = phantom.labels.table;
    planned_case.supports.labels.clear();
    return planned_case;
}

datasets::BlockParameters small_block()
{
    datasets::BlockParameters block;
    block.size_mm = { 90.0, 70.0, 90.0 };
    return block;
}

planner::Approach block_approach(const mesh::LabelVolume& labels, const Eigen::Isometry3d& X, double opening_mm)
{
    planner::ApproachRequest request;
    request.name = "straight";
    request.target.label = "target";
    request.sizing.corridor_edge_mm = 5.0;
    request.sizing.coarse_edge_mm = 12.0;
    request.view.eye_count = 19;
    const std::vector<Vec3> points { X * Vec3(1.3, 0.0, -25.0), X * Vec3(0.9, 0.0, 0.0), X * Vec3(1.3, 0.0, 25.0) };
    planner::Approach approach = planner::approach_from_points(labels, points, request).approach;
    approach.hooks = planner::make_hooks(approach, "2", opening_mm);
    approach.retracted = { "cavity" };
    return approach;
}

} // namespace retractor::test_support
