/// Prints the table of keys for people: `tribo-sim list --keys` and `--markdown`.

#ifndef SIM_KEY_LIST_H
#define SIM_KEY_LIST_H

/// Prints a line "key | type | range | default" for each key, or tables in Markdown, to standard output.
void sim_key_list_print(void);
void sim_key_list_print_markdown(void);

#endif
