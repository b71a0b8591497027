import sys; sys.path.insert(0,'/tmp/tune')
import cProfile,pstats,time
from explore2 import *
run(PidGains(),1)
t=time.time(); run(PidGains(),10,first=5); print((time.time()-t)/10)
pr=cProfile.Profile(); pr.enable(); run(PidGains(),10,first=30); pr.disable()
pstats.Stats(pr).sort_stats('tottime').print_stats(14)
