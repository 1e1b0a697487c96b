#include "ui/cli/framework/misspelling.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <cctype>
#include <cstddef>
#include <numeric>

namespace retractor::ui::cli {

namespace {

    /// Number of insertions, deletions, replacements and swaps of neighbours that turn one word into the other (optimal
    /// string alignment distance: Damerau, 1964, doi:10.1145/363958.363994).
    std::size_t distance(const std::string& a, const std::string& b)
    {
        std::vector<std::size_t> before, last(b.size() + 1), now(b.size() + 1);
        std::iota(last.begin(), last.end(), std::size_t { 0 });
        for (std::size_t i = 1; i <= a.size(); ++i) {
            now[0] = i;
            for (std::size_t j = 1; j <= b.size(); ++j) {
                const std::size_t replaced = last[j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1);
                now[j] = std::min({ last[j] + 1, now[j - 1] + 1, replaced });
                if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
                    now[j] = std::min(now[j], before[j - 2] + 1);
            }
            before = last;
            last = now;
        }
        return last[b.size()];
    }

    /// The end of the message, ": did you mean 'plan'?"; empty when no name is similar.
    std::string suggestion(const std::string& word, const std::vector<std::string>& names)
    {
        // One mistake in a word of three letters, two in a word of four to seven letters.
        std::size_t least = 2 + word.size() / 4;
        std::string nearest;
        for (const std::string& name : names)
            if (const std::size_t there = distance(word, name); there < least) {
                least = there;
                nearest = name;
            }
        return nearest.empty() ? std::string() : ": did you mean '" + nearest + "'?";
    }

    /// The beginning of the message, "approach add: "; empty for the program itself.
    std::string place_of(const CLI::App& command)
    {
        std::string names;
        for (const CLI::App* at = &command; at->get_parent() != nullptr; at = at->get_parent())
            names = at->get_name() + (names.empty() ? "" : " ") + names;
        return names.empty() ? names : names + ": ";
    }

    const CLI::App* subcommand_of(const CLI::App& command, const std::string& name)
    {
        for (const CLI::App* sub : command.get_subcommands({}))
            if (sub->get_name() == name)
                return sub;
        return nullptr;
    }

    /// The option of the command or of its parents, because options may stand anywhere.
    const CLI::Option* option_of(const CLI::App& command, const std::string& name)
    {
        for (const CLI::App* at = &command; at != nullptr; at = at->get_parent())
            if (const CLI::Option* option = at->get_option_no_throw(name))
                return option;
        return nullptr;
    }

    std::string unknown_command(const CLI::App& command, const std::string& word)
    {
        std::vector<std::string> names;
        for (const CLI::App* sub : command.get_subcommands({}))
            names.push_back(sub->get_name());
        return place_of(command) + "unknown command '" + word + "'" + suggestion(word, names);
    }

    std::string unknown_option(const CLI::App& command, const std::string& word)
    {
        std::vector<std::string> names;
        for (const CLI::App* at = &command; at != nullptr; at = at->get_parent())
            for (const CLI::Option* option : at->get_options())
                if (!option->get_group().empty())
                    for (const std::string& name : option->get_lnames())
                        names.push_back("--" + name);
        return place_of(command) + "unknown option '" + word + "'" + suggestion(word, names);
    }

    /// Whether the argument is an option such as "-h" or "--help", and not a number such as "-20,0,0".
    bool looks_like_option(const std::string& argument)
    {
        const std::size_t at = argument.find_first_not_of('-');
        return at != std::string::npos
            && (at == 2 || (at == 1 && std::isalpha(static_cast<unsigned char>(argument[1]))));
    }

} // namespace

std::string misspelling(const CLI::App& app, const std::vector<std::string>& arguments)
{
    const CLI::App* command = &app;
    std::size_t values = 0; // number of values that the last option still takes
    for (const std::string& argument : arguments) {
        if (argument == "--")
            break;
        if (values > 0) {
            --values;
        } else if (looks_like_option(argument)) {
            const std::size_t equals = argument.find('=');
            const std::string name = argument.substr(0, equals);
            const CLI::Option* const option = option_of(*command, name);
            if (option == nullptr)
                return unknown_option(*command, name);
            if (equals == std::string::npos)
                values = static_cast<std::size_t>(std::max(0, option->get_items_expected_min()));
        } else if (const CLI::App* const sub = subcommand_of(*command, argument)) {
            command = sub;
        } else if (command->get_require_subcommand_min() > 0) {
            return unknown_command(*command, argument);
        }
    }
    return {};
}

} // namespace retractor::ui::cli
