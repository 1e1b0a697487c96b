// Writes a phantom into the given folder as a case, reads it back and looks through the closed wall.
#include "datasets/io/volume_io.h"
#include "datasets/phantoms/phantom.h"
#include "planner/case/case_io.h"
#include "planner/case/patient.h"

#include <cstdio>
#include <filesystem>

int main(int, char** argv)
{
    const std::filesystem::path folder = std::filesystem::path(argv[1]) / "case";
    std::filesystem::create_directories(folder);
    retractor::datasets::BlockParameters block;
    block.size_mm = { 60.0, 60.0, 60.0 };
    const retractor::datasets::Phantom phantom = retractor::datasets::make_block_phantom(block);
    retractor::datasets::write_label_volume(folder / "labels.nrrd", phantom.labels);
    retractor::planner::Case planned;
    planned.folder = folder;
    planned.labels = retractor::planner::make_reference(folder, folder / "labels.nrrd");
    planned.label_table = phantom.labels.table;
    planned.supports.labels.clear();
    retractor::planner::write_case(planned);
    retractor::planner::Patient patient(retractor::planner::read_case(folder));
    std::printf("%zu triangles of skin\n", patient.body()->triangles.size());
    return patient.body()->triangles.size() > 1000 ? 0 : 1;
}
