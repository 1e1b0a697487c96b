// Cuts a slab of muscle by commands (60 x 20 x 60 mm, skin at y = 0) and reads what came of it from the snapshots.
#include "mesh/tetrahedra/tet_mesh.h"
#include "planner/session/surgery_worker.h"

#include <chrono>
#include <cstdio>
#include <thread>

namespace {

retractor::planner::SurgerySetup slab()
{
    retractor::planner::SurgerySetup setup;
    setup.wall = retractor::mesh::kuhn_box(12, 4, 12, 5.0);
    setup.labels = { { setup.wall.labels.front(), "muscle", "muscle", retractor::mesh::Role::wall } };
    return setup;
}

/// Straight down on the slab.
retractor::planner::Touch touched(const retractor::planner::SurgerySnapshot& now, double x)
{
    return *retractor::planner::touch(*now.picture, { { x, -50.0, 32.0 }, retractor::Vec3::UnitY() });
}

void wait_for(const retractor::planner::SurgeryWorker& worker)
{
    while (!worker.idle())
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
}

} // namespace

int main()
{
    retractor::planner::SurgeryWorker worker([](const retractor::Job&) { return slab(); }, [] {});
    wait_for(worker);
    const auto ready = worker.snapshot();
    if (ready->phase != retractor::planner::SurgerySnapshot::Phase::ready) {
        std::printf("%s\n", ready->failure.c_str());
        return 1;
    }
    worker.run(retractor::planner::surgery::BeginStroke { touched(*ready, 12.0), { .depth_mm = 8.0 } });
    for (double x = 16.0; x <= 48.0; x += 4.0)
        worker.run(retractor::planner::surgery::DrawTo { touched(*ready, x) });
    worker.run(retractor::planner::surgery::FinishStroke {});
    wait_for(worker);
    const auto cut = worker.snapshot();
    if (cut->cuts.size() != 1) {
        std::printf("%s\n", cut->answer.c_str());
        return 1;
    }
    std::printf(
        "a cut of %.0f mm, %d elements\n", cut->cuts[0].length_mm, static_cast<int>(cut->cuts[0].report.tets_crossed));
    return 0;
}
