#pragma once
// What can be asked of live surgery, as plain data: a front end fills a command in and gives it to KnifeWorker::run().
// A command that cannot be carried out changes nothing, unless it says otherwise here; the next snapshot says why.
// Units mm, N; frame patient LPS.

#include "planner/session/surgery_session.h"

#include <cstddef>
#include <filesystem>
#include <variant>

namespace retractor::planner {
namespace surgery {

    /// Sets the knife on the skin. A former stroke whose end was refused is finished first.
    struct BeginStroke {
        Touch at {};
        KnifeSettings settings {};
        std::size_t number = 1; ///< which stroke SessionSnapshot::refused_stroke means; the front end counts from 1
    };
    /// Draws the stroke on that was begun last. This command and the next two do nothing when that stroke was refused.
    struct DrawTo {
        Touch at {};
    };
    struct LeaveWall { }; ///< the knife is drawn where there is no wall
    struct FinishStroke { };
    struct AbandonStroke { }; ///< takes an open stroke back
    /// See SurgerySession::take_out().
    struct TakeOut {
        Touch at {};
        double radius_mm = 0.0;
    };

    struct Undo { }; ///< nothing where there is nothing to take back
    struct Redo { }; ///< nothing where there is nothing to make again
    /// Undoes or redoes until this many cuts are in force, or as near to that as can be.
    struct GoTo {
        std::size_t cuts = 0;
    };
    struct SetTension {
        double strain = 0.0;
    };

    struct PlaceHook {
        Touch at {};
    };
    struct TakePlannedHooks { };
    /// Draws one hook to a place, mm from rest. Of the commands that wait for the session only the newest of each hook
    /// counts, so that the wound follows the hand.
    struct PullHook {
        fem::HookId hook = 0;
        Vec3 asked = Vec3::Zero();
    };
    /// Draws each hook away from the other lip. Of this command and the next only the newest that waits counts.
    struct PullAllHooks {
        double mm = 0.0;
    };
    /// Drives the planned hooks by a share of their plan, 1 = as planned.
    struct PullHooksByShare {
        double share = 0.0;
    };
    /// Hooks slip rather than pull harder; infinite: only at their own limits.
    struct SetYield {
        double force_N = 0.0;
    };
    /// Whether wounds that hooks open are nonlinear near by.
    struct SetNonlinear {
        bool wanted = false;
    };
    struct TakeOffHook {
        fem::HookId hook = 0;
    };
    struct TakeOffHooks { };

    /// Writes the cut wall at rest as VTU and says so. Refused while a stroke is open.
    struct ExportWall {
        std::filesystem::path path {};
    };

    using Command = std::variant<BeginStroke, DrawTo, LeaveWall, FinishStroke, AbandonStroke, TakeOut, Undo, Redo, GoTo,
        SetTension, PlaceHook, TakePlannedHooks, PullHook, PullAllHooks, PullHooksByShare, SetYield, SetNonlinear,
        TakeOffHook, TakeOffHooks, ExportWall>;

} // namespace surgery
} // namespace retractor::planner
