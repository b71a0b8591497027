"""What ``bdt bench live`` measures with: pages, processes, the time a loop takes."""
