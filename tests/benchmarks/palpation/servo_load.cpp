#include "tests/benchmarks/palpation/servo_load.h"

#include "fem/interactive/online_opening.h"
#include "mesh/base/error.h"
#include "mesh/cutting/cut_session.h"
#include "tests/benchmarks/opening/open_scene.h"

namespace retractor::benchmarks {

namespace {

    constexpr const char* kBox = "12k";

    mesh::MeshDelta done(mesh::CutResult result)
    {
        if (result.status != mesh::CutStatus::done)
            throw SolverError("the load's cut was not made: " + result.message);
        return std::move(result.delta);
    }

    template <class Work> std::thread in_background(std::exception_ptr& error, Work work)
    {
        return std::thread([&error, work] {
            try {
                work();
            } catch (...) {
                error = std::current_exception();
            }
        });
    }

} // namespace

ServoLoad::ServoLoad(bool edits)
    : cutter_(in_background(cut_error_, [this] { cut_and_open(); }))
{
    if (edits)
        editor_ = in_background(edit_error_, [this] { edit(); });
}

ServoLoad::~ServoLoad()
{
    stopping_ = true;
    for (std::thread* thread : { &cutter_, &editor_ })
        if (thread->joinable())
            thread->join();
}

void ServoLoad::stop()
{
    stopping_ = true;
    for (std::thread* thread : { &cutter_, &editor_ })
        if (thread->joinable())
            thread->join();
    for (const std::exception_ptr& error : { cut_error_, edit_error_ })
        if (error)
            std::rethrow_exception(error);
}

void ServoLoad::cut_and_open()
{
    const OpenScene scene = open_scene_of_box(kBox);
    mesh::CutSession session(scene.mesh);
    fem::OnlineOpening opening(session, scene.materials, scene.supports, {});
    for (const fem::OnlineHook& hook : scene.hooks)
        opening.attach(hook);
    while (!stopping_) {
        opening.follow(done(session.cut(scene.blade)));
        fem::OnlineAnswer answer = opening.answer();
        opening.complete(answer);
        if (answer.status != fem::OnlineStatus::solved)
            throw SolverError("the load's wound was not opened: " + answer.message);
        opening.follow(session.undo());
        ++cuts_;
    }
}

void ServoLoad::edit()
{
    const OpenScene scene = open_scene_of_box(kBox);
    const mesh::CutSession session(scene.mesh);
    std::vector<fem::Material> materials = scene.materials;
    while (!stopping_) {
        for (fem::Material& material : materials)
            material.youngs_modulus_MPa *= edits_ % 2 == 0 ? 3.0 : 1.0 / 3.0;
        fem::OnlineOpening edited(session, materials, scene.supports, {});
        (void)edited.answer();
        ++edits_;
    }
}

} // namespace retractor::benchmarks
