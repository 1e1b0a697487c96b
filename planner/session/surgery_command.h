#pragma once
// Commands of live surgery, as plain data. A front end fills a command in and gives it to SurgeryWorker::run(). A
// command that cannot run changes nothing unless noted below; the next snapshot gives the reason. Units mm, N; frame
// patient LPS.

#include "planner/session/surgery_session.h"

#include <cstddef>
#include <filesystem>
#include <variant>

namespace retractor::planner {
namespace surgery {

    /// Sets the knife on the skin. Finishes an earlier stroke first when its end was refused.
    struct BeginStroke {
        Touch at {};
        KnifeSettings settings {};
        std::size_t number = 1; ///< number for SurgerySnapshot::refused_stroke; the front end counts from 1
    };
    /// Draws the last begun stroke on. DrawTo, LeaveWall and FinishStroke do nothing when that stroke was refused.
    struct DrawTo {
        Touch at {};
    };
    struct LeaveWall { }; ///< the knife moves where there is no wall
    struct FinishStroke { };
    struct AbandonStroke { }; ///< undoes an open stroke
    struct CutAsPlanned { }; ///< see SurgerySession::cut_as_planned()
    struct DivideBeyondCut { }; ///< see SurgerySession::divide_beyond_cut()
    /// See SurgerySession::take_out().
    struct TakeOut {
        Touch at {};
        double radius_mm = 0.0;
    };

    struct Undo { }; ///< see SurgerySession::undo_step(); does nothing when there is nothing to undo
    struct Redo { }; ///< does nothing when there is nothing to redo
    /// Undoes or redoes until this many cuts are active, or as close as possible.
    struct GoTo {
        std::size_t cuts = 0;
    };
    struct SetTension {
        double strain = 0.0;
    };

    struct PlaceHook {
        Touch at {};
    };
    /// See SurgerySession::place_retractor().
    struct PlaceRetractor {
        Touch at {};
        RetractorKind kind {};
    };
    /// Opens the retractor with this blade to a distance of its arms. Of the waiting commands only the newest for
    /// each blade runs.
    struct Crank {
        fem::HookId blade = 0;
        double opening_mm = 0.0;
    };
    struct TakePlannedHooks { };
    /// Tells what a new plan of the approach says; see SurgerySession::set_planned_force().
    struct SetPlannedForce {
        std::optional<PlannedForce> force {};
    };
    /// Pulls one hook to a displacement, mm from rest. Of the waiting commands only the newest for each hook runs, so
    /// that the wound follows the hand.
    struct PullHook {
        fem::HookId hook = 0;
        Vec3 asked = Vec3::Zero();
    };
    /// Pulls each hook away from the other lip. Of the waiting PullAllHooks and PullHooksByShare commands only the
    /// newest runs.
    struct PullAllHooks {
        double mm = 0.0;
    };
    /// Opens all planned hooks to this share of their planned force or displacement; 1 = as planned.
    struct PullHooksByShare {
        double share = 0.0;
    };
    /// Sets the force at which hooks slip; infinite: hooks slip only at their own limits.
    struct SetYield {
        double force_N = 0.0;
    };
    /// Whether wounds with hooks are solved nonlinearly near the wound.
    struct SetNonlinear {
        bool wanted = false;
    };
    struct TakeOffHook {
        fem::HookId hook = 0;
    };
    struct TakeOffHooks { };

    /// Tries again to write the cuts that wait for the disk; see SurgerySnapshot::cuts_not_saved.
    struct SaveCuts { };
    /// Writes the cut wall at rest by SurgerySetup::write_wall, with a message. Refused while a stroke is open.
    struct ExportWall {
        std::filesystem::path path {};
    };

    using Command = std::variant<BeginStroke, DrawTo, LeaveWall, FinishStroke, AbandonStroke, CutAsPlanned,
        DivideBeyondCut, TakeOut, Undo, Redo, GoTo, SetTension, PlaceHook, PlaceRetractor, Crank, TakePlannedHooks,
        PullHook, PullAllHooks, PullHooksByShare, SetPlannedForce, SetYield, SetNonlinear, TakeOffHook, TakeOffHooks,
        SaveCuts, ExportWall>;

} // namespace surgery
} // namespace retractor::planner
