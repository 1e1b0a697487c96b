#pragma once
// A small patient for tests: a layered block, a spherical target in the cavity under the block, and a straight cut over
// the target.

#include "datasets/phantoms/phantom.h"
#include "planner/case/approach.h"
#include "planner/case/case.h"

#include <Eigen/Geometry>

#include <string>

namespace retractor::test_support {

datasets::BlockParameters small_block();

/// The block as a case on disk, without a CT, in a new folder under the test's temporary folder.
planner::Case block_case(const std::string& name, const datasets::Phantom& phantom);

/// A cut of 50 mm over the target, off the grid, opened by `opening_mm`. X moves the patient.
planner::Approach block_approach(const mesh::LabelVolume& labels, const Eigen::Isometry3d& X, double opening_mm);

} // namespace retractor::test_support
