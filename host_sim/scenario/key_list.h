/// The table of keys for people: `tribo-sim list --keys` and `--markdown`.

#ifndef SIM_KEY_LIST_H
#define SIM_KEY_LIST_H

/// On standard output: "key | type | range | default" a line, or tables in Markdown.
void sim_key_list_print(void);
void sim_key_list_print_markdown(void);

#endif
