#include "mesh/cutting/cut_journal.h"

#include "mesh/base/error.h"
#include "tests/support/session_state.h"

#include <gtest/gtest.h>

#include <atomic>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <iomanip>
#include <iterator>
#include <random>
#include <sstream>

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

namespace retractor::mesh {
namespace cut_journal_test {

    namespace fs = std::filesystem;

    const Vec3 kExtent(15.0, 15.0, 9.0);

    TetMesh body() { return test_support::three_layers(5, 5, 3, 3.0); }

    class CutJournal : public testing::Test {
    protected:
        void SetUp() override
        {
            folder_ = fs::path(testing::TempDir())
                / (std::string("journal_") + testing::UnitTest::GetInstance()->current_test_info()->name() + "_"
                    + std::to_string(::getpid()));
            fs::remove_all(folder_);
            fs::create_directories(folder_);
            path_ = folder_ / "cuts.jsonl";
        }
        void TearDown() override { fs::remove_all(folder_); }

        std::string content() const
        {
            std::ifstream file(path_, std::ios::binary);
            return { std::istreambuf_iterator<char>(file), {} };
        }
        void write(const std::string& text) const { std::ofstream(path_, std::ios::binary) << text; }
        std::vector<std::string> lines() const
        {
            std::vector<std::string> all;
            std::istringstream text(content());
            for (std::string line; std::getline(text, line);)
                all.push_back(line + "\n");
            return all;
        }
        static std::string joined(const std::vector<std::string>& lines)
        {
            std::string text;
            for (const std::string& line : lines)
                text += line;
            return text;
        }
        /// The refusal when the journal is opened.
        InputError refusal() const
        {
            try {
                static_cast<void>(replay_journal(path_, body()));
            } catch (const InputError& error) {
                return error;
            }
            ADD_FAILURE() << "the journal was accepted";
            return InputError("");
        }

        fs::path folder_, path_;
    };

    /// One random operation, refused, cancelled and missed ones among them. True when it left a line in the journal.
    void random_operation(std::mt19937& random, CutSession& session, Blade& hand)
    {
        std::uniform_real_distribution<double> unit(0.0, 1.0);
        const auto attempt = [](auto&& work) {
            try {
                work();
            } catch (const SolverError&) { // a cut that cannot be made well leaves no trace
            } catch (const InputError&) {
            }
        };
        const double choice = unit(random);
        if (session.stroke_open()) {
            if (choice < 0.55) {
                hand.line.push_back(
                    hand.line.back() + Vec3(0.8 + unit(random), unit(random) - 0.5, 0.2 * (unit(random) - 0.5)));
                attempt([&] { static_cast<void>(session.extend_stroke(hand, { .crease_deg = 20.0 })); });
            } else if (choice < 0.85) {
                attempt([&] { static_cast<void>(session.finish_stroke()); });
            } else {
                static_cast<void>(session.abandon_stroke());
            }
            return;
        }
        if (choice < 0.3) {
            const double snap = unit(random) < 0.3 ? 0.0 : 0.35;
            const Blade blade = test_support::random_stroke(random, kExtent);
            attempt([&] { static_cast<void>(session.cut(blade, { .snap = snap })); });
        } else if (choice < 0.5) {
            hand = test_support::random_stroke(random, kExtent);
            hand.line.resize(2);
            hand.line[1] = hand.line[0] + Vec3(1.5, 0.4, 0.0);
            attempt([&] { static_cast<void>(session.extend_stroke(hand)); });
        } else if (choice < 0.6) {
            attempt(
                [&] { static_cast<void>(session.ablate(test_support::random_marks(random, session, kExtent, 2.5))); });
        } else if (choice < 0.75) {
            attempt([&] { static_cast<void>(session.undo()); });
        } else if (choice < 0.85) {
            attempt([&] { static_cast<void>(session.redo()); });
        } else if (choice < 0.95) {
            std::atomic<bool> cancel { false };
            Job job;
            job.cancel = &cancel;
            job.on_progress = [&](std::string_view, double fraction) { cancel = fraction > 0.2; };
            const Blade blade = test_support::random_stroke(random, kExtent);
            attempt([&] { static_cast<void>(session.cut(blade, {}, job)); });
        } else {
            attempt([&] { static_cast<void>(session.cut({})); });
        }
    }

    TEST_F(CutJournal, ReplayIsTheSameToTheLastBit)
    {
        for (unsigned seed = 0; seed < 6; ++seed) {
            fs::remove(path_);
            std::mt19937 random(seed);
            Blade hand;
            CutSession session = start_journal(path_, body());
            for (int i = 0; i < 22; ++i) {
                random_operation(random, session, hand);
                if (i % 8 == 7) {
                    const ReplayedJournal replayed = replay_journal(path_, body());
                    ASSERT_TRUE(test_support::SessionState(replayed.session) == test_support::SessionState(session))
                        << "seed " << seed;
                }
            }
            const test_support::SessionState before(session);
            session = CutSession(body()); // lets the file go
            ReplayedJournal reopened = open_journal(path_, body());
            ASSERT_TRUE(test_support::SessionState(reopened.session) == before) << "seed " << seed;
            EXPECT_EQ(reopened.message.empty(), !before.stroke);
            // It goes on.
            for (int i = 0; i < 5; ++i)
                random_operation(random, reopened.session, hand);
            const ReplayedJournal again = replay_journal(path_, body());
            ASSERT_TRUE(test_support::SessionState(again.session) == test_support::SessionState(reopened.session))
                << "seed " << seed;
        }
    }

    /// A journal with one of each operation, written by hand so that every line is known.
    void every_operation(CutSession& session)
    {
        Blade blade {
            .line = { { 2.1, 3.3, 9 }, { 12.4, 4.2, 9 } }, .directions = { { 0.1, 0.2, -1 } }, .depth_mm = 6
        };
        ASSERT_EQ(session.cut(blade).status, CutStatus::done);
        static_cast<void>(session.undo());
        static_cast<void>(session.redo());
        Blade hand { .line = { { 1.3, 9.1, 9 }, { 4.1, 9.4, 9 } }, .directions = { { 0, 0.1, -1 } }, .depth_mm = 5 };
        ASSERT_EQ(session.extend_stroke(hand).status, CutStatus::done);
        static_cast<void>(session.abandon_stroke());
        ASSERT_EQ(session.extend_stroke(hand).status, CutStatus::done);
        hand.line.emplace_back(8.3, 9.9, 9.0);
        ASSERT_EQ(session.extend_stroke(hand).status, CutStatus::done);
        ASSERT_EQ(session.finish_stroke().status, CutStatus::done);
        const std::vector<TetId> marked { 4, 5, 6, 100 };
        ASSERT_EQ(session.ablate(marked).status, CutStatus::done);
    }

    TEST_F(CutJournal, TornAnywhereInItsLastLineItOpensToTheStateBefore)
    {
        const auto small = [] { return test_support::three_layers(3, 3, 2, 4.5); };
        std::vector<test_support::SessionState> states;
        std::vector<std::size_t> sizes;
        {
            CutSession session = start_journal(path_, small());
            const auto note = [&] {
                states.emplace_back(session);
                sizes.push_back(fs::file_size(path_));
            };
            note();
            Blade blade {
                .line = { { 2.1, 3.3, 9 }, { 9.4, 4.2, 9 } }, .directions = { { 0, 0.2, -1 } }, .depth_mm = 4
            };
            ASSERT_EQ(session.cut(blade).status, CutStatus::done);
            note();
            blade.line.resize(1);
            blade.line.emplace_back(4.0, 9.0, 9.0);
            ASSERT_EQ(session.extend_stroke(blade).status, CutStatus::done);
            note();
            blade.line.emplace_back(5.0, 12.0, 9.0);
            ASSERT_EQ(session.extend_stroke(blade).status, CutStatus::done);
            note();
        }
        const std::string whole = content();
        for (std::size_t last = 1; last < states.size(); ++last)
            for (std::size_t size = sizes[last - 1]; size <= sizes[last]; ++size) {
                if (last + 1 < states.size() && size % 16 != 0)
                    continue; // every byte of the last line, some of the others
                write(whole.substr(0, size));
                const ReplayedJournal replayed = open_journal(path_, small());
                const bool complete = size == sizes[last];
                ASSERT_TRUE(test_support::SessionState(replayed.session) == states[complete ? last : last - 1])
                    << size << " bytes";
                EXPECT_EQ(
                    replayed.message.find("incomplete") != std::string::npos, !complete && size != sizes[last - 1])
                    << replayed.message;
                // What was torn is gone, so that the next line begins where a line may begin.
                EXPECT_EQ(fs::file_size(path_), complete ? sizes[last] : sizes[last - 1]);
            }
    }

    TEST_F(CutJournal, SurvivesAKill)
    {
        for (int round = 0; round < 5; ++round) {
            fs::remove(path_);
            std::array<int, 2> told {};
            ASSERT_EQ(::pipe(told.data()), 0);
            const ::pid_t child = ::fork();
            ASSERT_GE(child, 0);
            if (child == 0) { // cuts until it is killed, and says after each operation that it is done
                ::close(told[0]);
                std::mt19937 random(static_cast<unsigned>(round));
                CutSession session = start_journal(path_, body());
                for (;;) {
                    const Blade blade = test_support::random_stroke(random, kExtent);
                    bool done = false;
                    try {
                        done = session.cut(blade).status == CutStatus::done;
                        if (done && session.cut_count() > 3)
                            static_cast<void>(session.undo());
                    } catch (const Error&) {
                    }
                    const char byte = 'x';
                    if (done && ::write(told[1], &byte, 1) != 1)
                        ::_exit(1);
                }
            }
            ::close(told[1]);
            char byte = 0;
            const int wanted = 2 + 3 * round;
            int heard = 0;
            while (heard < wanted && ::read(told[0], &byte, 1) == 1)
                ++heard;
            // The time is what is tested: the child is killed somewhere within an operation, whichever that is.
            ::usleep(static_cast<::useconds_t>(1700 * round));
            ASSERT_EQ(::kill(child, SIGKILL), 0);
            int status = 0;
            ASSERT_EQ(::waitpid(child, &status, 0), child);
            ASSERT_TRUE(WIFSIGNALED(status));
            while (::read(told[0], &byte, 1) == 1)
                ++heard;
            ::close(told[0]);
            ASSERT_GE(heard, wanted);

            // The same hand without a kill, stopped where the journal stops.
            ReplayedJournal survived = open_journal(path_, body());
            EXPECT_GE(survived.operations, static_cast<std::size_t>(heard));
            std::mt19937 random(static_cast<unsigned>(round));
            CutSession session(body());
            std::size_t operations = 0;
            while (operations < survived.operations) {
                const Blade blade = test_support::random_stroke(random, kExtent);
                try {
                    if (session.cut(blade).status != CutStatus::done)
                        continue;
                    ++operations;
                    if (session.cut_count() > 3 && operations < survived.operations) {
                        static_cast<void>(session.undo());
                        ++operations;
                    }
                } catch (const Error&) {
                }
            }
            EXPECT_TRUE(test_support::SessionState(survived.session) == test_support::SessionState(session));
            const Blade last {
                .line = { { 3, 7.7, 9 }, { 11, 8.1, 9 } }, .directions = { { 0, 0, -1 } }, .depth_mm = 3
            };
            const auto cut = [&](CutSession& s) { return s.cut(last).status; };
            EXPECT_EQ(cut(survived.session), cut(session));
        }
    }

    TEST_F(CutJournal, DamageIsRefusedByLine)
    {
        {
            CutSession session = start_journal(path_, body());
            every_operation(session);
            EXPECT_THROW(static_cast<void>(open_journal(path_, body())), IoError); // one writer at a time
        }
        const std::vector<std::string> good = lines();
        ASSERT_EQ(good.size(), 10u);
        EXPECT_EQ(replay_journal(path_, body()).operations, 9u);

        for (std::size_t i = 0; i < good.size(); ++i) {
            std::vector<std::string> bad = good;
            const std::size_t digit = bad[i].find_first_of("123456789", bad[i].size() / 3);
            ASSERT_NE(digit, std::string::npos);
            bad[i][digit] = bad[i][digit] == '1' ? '2' : '1';
            write(joined(bad));
            const InputError error = refusal();
            EXPECT_EQ(error.where(), path_.string() + ":" + std::to_string(i + 1)) << error.what();
        }
        std::vector<std::string> missing = good;
        missing.erase(missing.begin() + 4);
        write(joined(missing));
        EXPECT_EQ(refusal().where(), path_.string() + ":5");
        std::vector<std::string> swapped = good;
        std::swap(swapped[2], swapped[3]);
        write(joined(swapped));
        EXPECT_EQ(refusal().where(), path_.string() + ":3");
        std::vector<std::string> doubled = good;
        doubled.insert(doubled.begin() + 3, doubled[2]);
        write(joined(doubled));
        EXPECT_EQ(refusal().where(), path_.string() + ":4");
        std::vector<std::string> foreign = good;
        foreign[5] = "hello\n";
        write(joined(foreign));
        EXPECT_EQ(refusal().where(), path_.string() + ":6");
        write("");
        EXPECT_NE(std::string(refusal().what()).find("no journal"), std::string::npos);
        write("{\"schema\": 1}\n");
        EXPECT_EQ(refusal().where(), path_.string() + ":1");
    }

    TEST_F(CutJournal, AnotherMeshIsRefused)
    {
        {
            CutSession session = start_journal(path_, body());
            every_operation(session);
        }
        TetMesh moved = body();
        moved.vertices(7, 1) += 1e-9;
        EXPECT_THROW(static_cast<void>(replay_journal(path_, moved)), InputError);
        TetMesh relabelled = body();
        relabelled.labels[3] = 9;
        try {
            static_cast<void>(open_journal(path_, relabelled));
            FAIL() << "a journal of another mesh was accepted";
        } catch (const InputError& error) {
            EXPECT_NE(std::string(error.what()).find("another mesh"), std::string::npos);
            EXPECT_EQ(error.where(), path_.string() + ":1");
        }
        EXPECT_THROW(static_cast<void>(start_journal(path_, body())), IoError); // never over what is there
        EXPECT_THROW(static_cast<void>(open_journal(folder_ / "none.jsonl", body())), IoError);
        EXPECT_THROW(static_cast<void>(start_journal(folder_ / "none" / "cuts.jsonl", body())), IoError);
    }

    /// A journal's line with another text, and with a check that fits: FNV-1a over the check of the line before (a 0
    /// of eight bytes before the first line) and the line.
    std::string changed_line(
        const std::string& before, const std::string& line, const std::string& from, const std::string& to)
    {
        const std::string mark = ",\"check\":\"";
        const std::uint64_t check
            = before.empty() ? 0 : std::stoull(before.substr(before.find(mark) + mark.size(), 16), nullptr, 16);
        std::string text = line.substr(0, line.find(mark));
        text.replace(text.find(from), from.size(), to);
        std::uint64_t value = 14695981039346656037U;
        const auto add = [&](char c) { value = (value ^ static_cast<unsigned char>(c)) * 1099511628211U; };
        for (int i = 0; i < 8; ++i)
            add(static_cast<char>(check >> (8 * i)));
        std::for_each(text.begin(), text.end(), add);
        std::ostringstream end;
        end << mark << std::hex << std::setw(16) << std::setfill('0') << value << "\"}\n";
        return text + end.str();
    }

    TEST_F(CutJournal, AnotherVersionIsRefusedByName)
    {
        {
            CutSession session = start_journal(path_, body());
        }
        const std::string now = "\"version\":" + std::to_string(kCutJournalVersion);
        const std::string head = lines().front();
        ASSERT_NE(head.find(now), std::string::npos) << head;
        const auto with_version = [&](const std::string& version) { return changed_line({}, head, now, version); };
        ASSERT_EQ(with_version(now), head);
        for (const int version : { 1, 2, 3, kCutJournalVersion + 1 }) { // the older cutters made other elements
            write(with_version("\"version\":" + std::to_string(version)));
            const InputError error = refusal();
            EXPECT_EQ(std::string(error.what()),
                "the journal has version " + std::to_string(version) + ", written by "
                    + (version < kCutJournalVersion ? "an older" : "a newer") + " program; this program reads version "
                    + std::to_string(kCutJournalVersion));
            EXPECT_EQ(error.where(), path_.string() + ":1");
        }
    }

    TEST_F(CutJournal, AnotherSubdivisionIsRefusedByName)
    {
        {
            CutSession session = start_journal(path_, body());
            ASSERT_EQ(session
                          .cut({ .line = { { 2.1, 3.3, 9 }, { 9.4, 4.2, 9 } },
                              .directions = { { 0, 0.2, -1 } },
                              .depth_mm = 4 })
                          .status,
                CutStatus::done);
        }
        const std::vector<std::string> written = lines();
        ASSERT_EQ(written.size(), 2u);
        const std::string adaptive = "\"subdivision\":\"adaptive\"";
        ASSERT_NE(written[1].find(adaptive), std::string::npos) << written[1];
        ASSERT_EQ(changed_line(written[0], written[1], adaptive, adaptive), written[1]);
        write(written[0] + changed_line(written[0], written[1], adaptive, "\"subdivision\":\"general\""));
        const InputError error = refusal();
        EXPECT_STREQ(error.what(),
            "the subdivision is \"general\"; this version cuts adaptively only: replay the journal with the version "
            "that "
            "wrote it");
        EXPECT_EQ(error.where(), path_.string() + ":2 (/options/subdivision)");
    }

    /// A short cut across the top of the body.
    CutStatus cut_across(CutSession& session, double y)
    {
        const Blade blade {
            .line = { { 2.1, y, 9 }, { 9.4, y + 0.9, 9 } }, .directions = { { 0, 0.2, -1 } }, .depth_mm = 4
        };
        return session.cut(blade).status;
    }

    TEST_F(CutJournal, AFullDiskTakesTheOperationBack)
    {
        // In a child, as the limit on file sizes is the whole process'.
        const ::pid_t child = ::fork();
        ASSERT_GE(child, 0);
        if (child == 0) {
            CutSession session = start_journal(path_, body());
            const test_support::SessionState before(session);
            const std::size_t size = fs::file_size(path_);
            static_cast<void>(::signal(SIGXFSZ, SIG_IGN));
            const ::rlimit limit { size + 40, size + 40 }; // a part of the line still fits
            if (::setrlimit(RLIMIT_FSIZE, &limit) != 0)
                ::_exit(2);
            try {
                static_cast<void>(cut_across(session, 3.3));
            } catch (const IoError&) {
                ::_exit(test_support::SessionState(session) == before && fs::file_size(path_) == size ? 0 : 3);
            }
            ::_exit(4);
        }
        int status = 0;
        ASSERT_EQ(::waitpid(child, &status, 0), child);
        ASSERT_TRUE(WIFEXITED(status));
        EXPECT_EQ(WEXITSTATUS(status), 0);
        EXPECT_EQ(replay_journal(path_, body()).operations, 0u);
    }

    TEST_F(CutJournal, LinesWaitWhileTheDiskIsFull)
    {
        const ::pid_t child = ::fork(); // as above
        ASSERT_GE(child, 0);
        if (child == 0) {
            static_cast<void>(::signal(SIGXFSZ, SIG_IGN));
            const auto allow = [](::rlim_t bytes) {
                const ::rlimit limit { bytes, RLIM_INFINITY };
                if (::setrlimit(RLIMIT_FSIZE, &limit) != 0)
                    ::_exit(2);
            };
            const auto cut = [](CutSession& session, double y) {
                if (cut_across(session, y) != CutStatus::done)
                    ::_exit(5);
            };
            WaitingLines waiting;
            allow(0); // full from the beginning, then in the middle
            CutSession session = start_patient_journal(path_, body(), waiting);
            cut(session, 2.3);
            if (waiting.reason().empty() || fs::file_size(path_) != 0)
                ::_exit(3);
            allow(RLIM_INFINITY);
            if (!waiting.write() || !waiting.reason().empty())
                ::_exit(4);
            const std::size_t size = fs::file_size(path_);
            allow(size + 40); // a part of the next line still fits
            cut(session, 6.3);
            if (waiting.reason().empty() || fs::file_size(path_) != size)
                ::_exit(6);
            allow(RLIM_INFINITY);
            cut(session, 10.3); // writes what waits
            ::_exit(waiting.reason().empty() ? 0 : 7);
        }
        int status = 0;
        ASSERT_EQ(::waitpid(child, &status, 0), child);
        ASSERT_TRUE(WIFEXITED(status));
        EXPECT_EQ(WEXITSTATUS(status), 0);
        EXPECT_EQ(replay_journal(path_, body()).operations, 3u);
    }

    TEST_F(CutJournal, ADeletedFileIsWrittenAnew)
    {
        const fs::path inside = folder_ / "cuts" / "median.jsonl";
        {
            WaitingLines waiting;
            CutSession session = start_patient_journal(inside, body(), waiting);
            ASSERT_EQ(cut_across(session, 2.3), CutStatus::done);
            EXPECT_EQ(waiting.reason(), "");
            fs::remove_all(folder_);
            ASSERT_EQ(cut_across(session, 6.3), CutStatus::done);
            EXPECT_NE(waiting.reason(), "") << "the folder above has gone, too";
            EXPECT_FALSE(fs::exists(folder_));
            fs::create_directories(folder_);
            EXPECT_TRUE(waiting.write());
            EXPECT_EQ(replay_journal(inside, body()).operations, 2u);
        }
        WaitingLines waiting;
        ReplayedJournal reopened = open_patient_journal(inside, body(), waiting);
        fs::remove_all(inside.parent_path());
        ASSERT_EQ(cut_across(reopened.session, 10.3), CutStatus::done);
        EXPECT_EQ(waiting.reason(), "");
        EXPECT_EQ(replay_journal(inside, body()).operations, 3u);
    }

    TEST_F(CutJournal, ACancelledReplaySaysSo)
    {
        {
            CutSession session = start_journal(path_, body());
            every_operation(session);
        }
        const std::string before = content();
        const std::atomic<bool> cancel { true };
        Job job;
        job.cancel = &cancel;
        EXPECT_EQ(open_journal(path_, body(), job).status, CutStatus::cancelled);
        EXPECT_EQ(content(), before);
    }

} // namespace cut_journal_test
} // namespace retractor::mesh
