"""Steps of the search: add, drop, merge or replace an effect."""
