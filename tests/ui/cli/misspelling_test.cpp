#include "ui/cli/framework/misspelling.h"

#include <CLI/CLI.hpp>
#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace retractor::ui {
namespace misspelling_test {

    /// A program of two commands, one of which has two of its own.
    class Misspelling : public testing::Test {
    protected:
        Misspelling()
        {
            app_.require_subcommand(1);
            app_.fallthrough();
            app_.add_flag("--json");
            app_.add_option("--threads", threads_);
            CLI::App* plan = app_.add_subcommand("plan");
            plan->add_option("case", case_);
            plan->add_option("--opening", opening_);
            plan->add_option("--points", points_);
            plan->add_flag("--own-drawing")->group("");
            CLI::App* approach = app_.add_subcommand("approach");
            approach->require_subcommand(1);
            approach->add_subcommand("add")->add_option("--target", case_);
            approach->add_subcommand("remove");
        }
        std::string said(const std::vector<std::string>& arguments) const
        {
            return ui::cli::misspelling(app_, arguments);
        }

        CLI::App app_ { "a program", "retractor" };
        int threads_ = 0;
        double opening_ = 0.0;
        std::string case_;
        std::vector<std::string> points_;
    };

    TEST_F(Misspelling, OfACommandNamesTheNearest)
    {
        EXPECT_EQ(said({ "plna", "case.json" }), "unknown command 'plna': did you mean 'plan'?");
        EXPECT_EQ(
            said({ "--threads", "2", "--json", "aproach" }), "unknown command 'aproach': did you mean 'approach'?");
        EXPECT_EQ(said({ "approach", "remvoe" }), "approach: unknown command 'remvoe': did you mean 'remove'?");
        EXPECT_EQ(said({ "no-such-command" }), "unknown command 'no-such-command'") << "nothing is similar";
    }

    TEST_F(Misspelling, OfAnOptionNamesTheNearest)
    {
        EXPECT_EQ(said({ "plan", "case.json", "--opning", "30" }),
            "plan: unknown option '--opning': did you mean '--opening'?");
        EXPECT_EQ(said({ "plan", "--opning=30" }), "plan: unknown option '--opning': did you mean '--opening'?");
        EXPECT_EQ(said({ "approach", "add", "--taget", "aorta" }),
            "approach add: unknown option '--taget': did you mean '--target'?");
        EXPECT_EQ(said({ "plan", "--thread", "2" }), "plan: unknown option '--thread': did you mean '--threads'?");
        EXPECT_EQ(said({ "plan", "--own-drawin" }), "plan: unknown option '--own-drawin'") << "it is hidden";
        EXPECT_EQ(said({ "approach", "add", "--opening", "30" }), "approach add: unknown option '--opening'");
    }

    TEST_F(Misspelling, IsNotSeenInWhatExists)
    {
        EXPECT_EQ(said({}), "");
        EXPECT_EQ(said({ "plan", "plna", "--opening", "--opning", "--json" }), "") << "a file and a value";
        EXPECT_EQ(said({ "plan", "--points", "-20,0,0", "-5,-3,2", "--help", "-h" }), "") << "numbers are no options";
        EXPECT_EQ(said({ "plan", "--", "--opning" }), "") << "what follows -- is no option";
    }

} // namespace misspelling_test
} // namespace retractor::ui
