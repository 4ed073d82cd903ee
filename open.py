import sys,numpy as np,cv2
from pathlib import Path
from caricli.store.rig_sources import load_rig
from caricli.render.rig_stage import RigStage
rows=[]
for f in sys.argv[2:]:
    r=load_rig(Path(f)); k=list(r.names).index('jawOpen'); row=[]
    for view in ('front','three-quarter'):
        st=RigStage(r,view,500)
        for w in ((0,1) if view=='front' else (1,)): row.append(st.picture(r.neutral+w*r.deltas[k]))
    rows.append(np.concatenate(row,1))
cv2.imwrite(sys.argv[1],np.concatenate(rows)[...,::-1])
